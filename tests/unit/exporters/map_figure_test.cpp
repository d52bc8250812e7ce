// map.png: what the picture shows.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "small_run.h"

namespace dynemo::test {
namespace {

cv::Mat picture(const RunResult& run) {
  const std::string png = exported("map", run);
  return cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_COLOR);
}

/// A wall 4 m ahead, seen from keyframe 0 and, 0.3 m off in its own estimate, from the last one.
class MapFigure : public testing::Test {
 protected:
  MapFigure() {
    auto scan = std::make_shared<Scan>();
    for (int i = 0; i < 2000; ++i) {
      scan->cloud.points.emplace_back(4.0F, -2.0F + 0.002F * static_cast<float>(i), 1.0F);
      scan->cloud.points.emplace_back(2.0F, -2.0F + 0.002F * static_cast<float>(i), 0.0F);
    }
    for (const auto& keyframe : run_.graph.keyframes()) {
      keyframe->scan = scan;
      keyframe->floor.reset();
      keyframe->T_map_node = Pose3();
      aligned_.push_back(Pose3());
      apart_.push_back(Pose3::translation(0.1 * static_cast<double>(apart_.size()), 0, 0));
    }
  }
  static int inked(const cv::Mat& picture, const cv::Rect& part) {
    int count = 0;
    const cv::Mat region = picture(part);
    for (int y = 0; y < region.rows; ++y) {
      for (int x = 0; x < region.cols; ++x)
        count += region.at<cv::Vec3b>(y, x) != cv::Vec3b(255, 255, 255);
    }
    return count;
  }

  SmallRun run_ = smallRun();
  std::vector<Pose3> aligned_, apart_;
};

TEST_F(MapFigure, IsOnePanelWithoutClosuresAndTwoWith) {
  const cv::Mat one = picture(run_.result());
  RunResult result = run_.result();
  result.keyframes_without_closures = apart_;
  const cv::Mat two = picture(result);
  EXPECT_GT(two.cols, 3 * one.cols / 2);
}

TEST_F(MapFigure, WallsThatAreDoubleBeforeAreSingleAfter) {
  RunResult result = run_.result();
  result.keyframes_without_closures = apart_;
  const cv::Mat both = picture(result);
  const int half = both.cols / 2;
  const int before = inked(both, {0, 0, half, both.rows});
  const int after = inked(both, {half, 0, both.cols - half, both.rows});
  EXPECT_GT(before, after);
  result.keyframes_without_closures = aligned_;
  const cv::Mat same = picture(result);
  EXPECT_GT(before, inked(same, {0, 0, same.cols / 2, same.rows}));
}

}  // namespace
}  // namespace dynemo::test
