// Recordings of other people, from the folder named by the environment variable DYNEMO_REAL_DATA.
#include <gtest/gtest.h>

#include <cstdlib>

#include "dynemo/ingest/rawlog_source.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

class RealRawlogs : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("DYNEMO_REAL_DATA");
    if (folder == nullptr) GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
    folder_ = fs::path(folder) / "rawlog/mrpt";
  }
  std::vector<SensorFrame> frames(const std::string& name) {
    source_ = makeRawlogSource(params_, folder_ / name);
    return allFrames(*source_);
  }
  fs::path folder_;
  IngestParams params_;
  std::unique_ptr<FrameSource> source_;
};

TEST_F(RealRawlogs, VelodyneVlp16) {
  params_.lidar.min_range_m = 0;
  params_.lidar.max_range_m = 1000;
  const auto all = frames("test_velodyne_VLP16.rawlog");
  ASSERT_EQ(all.size(), 1U);
  const PointCloud& cloud = all[0].scan->cloud;
  EXPECT_EQ(cloud.size(), 11305U);
  ASSERT_EQ(cloud.time_offset_s.size(), cloud.size());
  const auto [first, last] =
      std::minmax_element(cloud.time_offset_s.begin(), cloud.time_offset_s.end());
  EXPECT_GE(*first, -0.002F);
  EXPECT_GT(*last, 0.09F);
  EXPECT_LT(*last, 0.11F);
}

TEST_F(RealRawlogs, DepthCamera) {
  params_.lidar.min_range_m = 0;
  const auto all = frames("tests_rgbd.rawlog");
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].scan->cloud.size(), 273225U);
  EXPECT_EQ(all[0].scan->cloud.rows, 480);
  EXPECT_EQ(all[0].scan->cloud.columns, 640);
}

TEST_F(RealRawlogs, DepthCameraInASensoryFrame) {
  const auto all = frames("test-3d-obs-ground.rawlog");
  ASSERT_EQ(all.size(), 1U);
  EXPECT_GT(all[0].scan->cloud.size(), 10000U);
}

TEST_F(RealRawlogs, RotatingScanNeedsElevations) {
  try {
    frames("rot_scan_velodyne.rawlog");
    FAIL() << "points without elevations";
  } catch (const std::exception& e) {
    EXPECT_NE(std::string(e.what()).find("lidar.elevations_deg must list 16"), std::string::npos)
        << e.what();
  }
  for (int i = 0; i < 16; ++i)
    params_.lidar.elevations_deg.push_back(i % 2 == 0 ? -15 + i : i);  // VLP-16 firing order
  const auto all = frames("rot_scan_velodyne.rawlog");
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].scan->cloud.rows, 16);
  EXPECT_GT(all[0].scan->cloud.size(), 5000U);
}

TEST_F(RealRawlogs, OdometryActionsWithTwoDimensionalLaser) {
  const auto all = frames("2006-01ENE-21-SENA_Telecom_Faculty_one_loop_only.rawlog");
  EXPECT_EQ(source_->report().observations.at("(no label) (CObservation2DRangeScan)"), 225U);
  ASSERT_EQ(all.size(), 225U);
  double travelled_m = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    travelled_m += (all[i].odometry->T_odom_base.t - all[i - 1].odometry->T_odom_base.t).norm();
  EXPECT_GT(travelled_m, 20.0);
  EXPECT_LT(travelled_m, 2000.0);
}

TEST_F(RealRawlogs, OldFormatWithoutActionStamps) {
  EXPECT_EQ(frames("localization_demo.rawlog").size(), 37U);
}

}  // namespace
}  // namespace dynemo
