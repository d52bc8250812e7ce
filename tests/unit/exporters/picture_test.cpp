// The rendered picture: that something is in it, and that the camera is where the labels think.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "picture_camera.h"
#include "scene_view.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

cv::Mat picture(const RunResult& run, PngView view) {
  ExportParams params;
  params.png = {160, 120, view};
  const std::string bytes = exported("png", run, params);
  return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_COLOR);
}

std::size_t colors(const cv::Mat& image) {
  std::set<std::uint32_t> seen;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto& p = image.at<cv::Vec3b>(y, x);
      seen.insert(p[0] << 16u | p[1] << 8u | p[2]);
    }
  }
  return seen.size();
}

TEST(Picture, ShowsTheSceneFromTheAskedSides) {
  const SmallRun run = smallRun();
  const cv::Mat above = picture(run.result(), PngView::kAbove);
  const cv::Mat both = picture(run.result(), PngView::kBoth);
  EXPECT_EQ(above.size(), cv::Size(160, 120));
  EXPECT_EQ(both.size(), cv::Size(320, 120));
  EXPECT_GT(colors(above), 15u);
  EXPECT_EQ(cv::norm(both(cv::Rect(160, 0, 160, 120)), above), 0.0);
  EXPECT_GT(cv::norm(both(cv::Rect(0, 0, 160, 120)), above), 0.0);
}

TEST(Picture, TheCameraLooksAtThePointUpright) {
  const Vector3 p(3.0, -2.0, 1.0);
  for (const double elevation : {0.0, 0.8, 0.5 * std::numbers::pi}) {
    const PictureCamera camera = lookAt(p, 10.0, 0.7, elevation, 0.6, 640, 480);
    const Matrix3& R = camera.T_map_camera.R;
    EXPECT_LT((R.transpose() * R - Matrix3::Identity()).norm(), 1e-12);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
    EXPECT_NEAR((camera.T_map_camera.t - p).norm(), 10.0, 1e-12);
    const auto middle = camera.project(p);
    ASSERT_TRUE(middle);
    EXPECT_LT((*middle - Vector2(320, 240)).norm(), 1e-9);
    // The upper edge of the picture is half the field of view away.
    const Vector3 edge(0.0, -10.0 * std::tan(0.3), 10.0);
    EXPECT_NEAR(camera.project(camera.T_map_camera * edge)->y(), 0.0, 1e-9);
    if (elevation < 1.0) {
      EXPECT_LT(camera.project(p + Vector3::UnitZ())->y(), middle->y());
    }
    EXPECT_FALSE(camera.project(camera.T_map_camera * Vector3(0.0, 0.0, -1.0)));
  }
}

TEST(Picture, TheViewLiesAlongTheLongSide) {
  SmallRun run = smallRun();
  const double yaw = 0.6;
  auto scan = std::make_shared<Scan>();
  for (int i = -100; i <= 100; ++i) {
    for (int k = -20; k <= 20; ++k) {
      const Vector3 p(0.1 * i, 0.1 * k, 0.0);
      scan->cloud.points.push_back((Pose3::fromYawPitchRoll(0, 0, 0, yaw, 0, 0) * p).cast<float>());
    }
  }
  run.graph.setScan({0}, scan);
  for (const std::uint64_t other : {1u, 5u}) run.graph.setScan({other}, nullptr);
  const SceneView view = viewOf(run.graph);
  EXPECT_NEAR(view.yaw_rad, yaw, 0.06);
  EXPECT_NEAR(view.half_m.x(), 10.0, 1.0);
  EXPECT_NEAR(view.half_m.y(), 2.0, 1.0);
  EXPECT_LT((view.center - Vector3::Zero()).norm(), 1.0);
}

}  // namespace
}  // namespace dynemo::test
