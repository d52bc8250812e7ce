#include "dynemo/perception/camera_projection.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <vector>

#include "tag_scene.h"

namespace dynemo {
namespace {

constexpr double kPixelTolerance = 1e-9;
constexpr double kBearingTolerance = 1e-10;
constexpr double kStep_m = 1e-6;
constexpr double kJacobianTolerance = 1e-4;  // px per m, of values around 500

class EveryLensProjects : public ::testing::TestWithParam<DistortionModel> {};

std::vector<Vector3> pointsInView() {
  std::vector<Vector3> points;
  for (const double x : {-1.2, -0.3, 0.0, 0.7}) {
    for (const double y : {-0.8, 0.0, 0.5}) points.emplace_back(x, y, 2.0);
  }
  return points;
}

TEST_P(EveryLensProjects, BearingInvertsProjection) {
  const CameraModel camera = test::testCamera(GetParam());
  for (const Vector3& p : pointsInView()) {
    const auto projection = project(camera, p);
    ASSERT_TRUE(projection);
    const auto ray = bearing(camera, projection->pixel);
    ASSERT_TRUE(ray) << p.transpose();
    EXPECT_LT((*ray - p.normalized()).norm(), kBearingTolerance) << p.transpose();
  }
}

TEST_P(EveryLensProjects, JacobianMatchesCentralDifferences) {
  const CameraModel camera = test::testCamera(GetParam());
  for (const Vector3& p : pointsInView()) {
    const auto at = project(camera, p);
    for (int k = 0; k < 3; ++k) {
      const Vector3 step = kStep_m * Vector3::Unit(k);
      const Vector2 difference =
          (project(camera, p + step)->pixel - project(camera, p - step)->pixel) / (2 * kStep_m);
      EXPECT_LT((at->J_pixel_point.col(k) - difference).norm(), kJacobianTolerance)
          << p.transpose();
    }
  }
}

cv::Point2d projectWithOpenCv(const CameraModel& camera, const Vector3& p) {
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const std::vector<cv::Point3d> points{{p.x(), p.y(), p.z()}};
  const std::vector<double> k(camera.coefficients.begin(), camera.coefficients.end());
  const cv::Vec3d zero(0, 0, 0);
  std::vector<cv::Point2d> pixels;
  if (camera.distortion == DistortionModel::kKannalaBrandt) {
    cv::fisheye::projectPoints(points, pixels, zero, zero, K,
                               std::vector<double>(k.begin(), k.begin() + 4));
  } else {
    cv::projectPoints(points, zero, zero, K, k, pixels);
  }
  return pixels.front();
}

TEST_P(EveryLensProjects, AgreesWithOpenCv) {
  const CameraModel camera = test::testCamera(GetParam());
  for (const Vector3& p : pointsInView()) {
    const cv::Point2d expected = projectWithOpenCv(camera, p);
    EXPECT_LT((project(camera, p)->pixel - Vector2(expected.x, expected.y)).norm(),
              kPixelTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, EveryLensProjects,
                         ::testing::Values(DistortionModel::kNone, DistortionModel::kPlumbBob,
                                           DistortionModel::kKannalaBrandt));

TEST(CameraProjection, RationalPlumbBobAgreesWithOpenCv) {
  CameraModel camera = test::testCamera(DistortionModel::kPlumbBob);
  camera.coefficients = {0.3, -0.1, 1e-3, -5e-4, 0.02, 0.6, -0.05, 0.01};
  for (const Vector3& p : pointsInView()) {
    const cv::Point2d expected = projectWithOpenCv(camera, p);
    EXPECT_LT((project(camera, p)->pixel - Vector2(expected.x, expected.y)).norm(),
              kPixelTolerance);
  }
}

TEST(CameraProjection, NothingIsSeenBehindAPinholeCamera) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  EXPECT_FALSE(project(camera, Vector3(0.1, 0.1, -1.0)));
  EXPECT_FALSE(project(camera, Vector3(0.1, 0.1, 0.0)));
  EXPECT_FALSE(project(camera, Vector3(NAN, 0.1, 1.0)));
}

TEST(CameraProjection, FisheyeSeesBeyondNinetyDegrees) {
  CameraModel camera = test::testCamera(DistortionModel::kKannalaBrandt);
  camera.coefficients = {};
  const Vector3 p(1.0, 0.0, -0.1);
  const auto projection = project(camera, p);
  ASSERT_TRUE(projection);
  EXPECT_LT((*bearing(camera, projection->pixel) - p.normalized()).norm(), kBearingTolerance);
}

TEST(CameraProjection, FoldedDistortionIsNotSeen) {
  CameraModel camera = test::testCamera(DistortionModel::kPlumbBob);
  camera.coefficients = {-0.5};  // r(1 − r²/2) has its maximum at r = 0.816
  EXPECT_TRUE(project(camera, Vector3(0.7, 0.0, 1.0)));
  EXPECT_FALSE(project(camera, Vector3(1.2, 0.0, 1.0)));
  EXPECT_FALSE(bearing(camera, Vector2(camera.cx + 0.9 * camera.fx, camera.cy)));
}

}  // namespace
}  // namespace dynemo
