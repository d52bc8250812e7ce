// What every registered method promises.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "dynemo/core/config.h"
#include "dynemo/odometry/odometry_params.h"
#include "dynemo/odometry/scan_odometry.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

class ScanOdometries : public ::testing::TestWithParam<std::string> {
 protected:
  static std::vector<OdometryEstimate> run(const std::string& method, int threads) {
    OdometryParams params;
    params.threads = threads;
    const auto odometry = scanOdometries().make(method, params);
    test::LidarModel lidar;
    lidar.rows = 24;
    lidar.columns = 360;
    lidar.sweep_s = 0.0;
    std::mt19937_64 random(21);
    std::vector<OdometryEstimate> estimates;
    for (int i = 0; i < 25; ++i) {
      const Scan scan =
          test::sweep(test::furnishedRoom(), lidar, test::wheeledDrive(), 0.1 * i, random);
      const auto estimate = odometry->update(scan, std::nullopt);
      EXPECT_TRUE(estimate) << "scan " << i;
      if (estimate) estimates.push_back(*estimate);
    }
    return estimates;
  }
};

TEST_P(ScanOdometries, FollowsASmoothDrive) {
  constexpr double kTolerance_m = 0.06, kTolerance_rad = 0.02;
  const auto estimates = run(GetParam(), 1);
  ASSERT_EQ(estimates.size(), 25U);
  EXPECT_TRUE(estimates[0].T_odom_base.t.isZero());
  const Pose3 T_first_last = test::wheeledDrive()(0.0).inverse() * test::wheeledDrive()(2.4);
  const Vector6 error = local(T_first_last, estimates.back().T_odom_base);
  EXPECT_LT(error.head<3>().norm(), kTolerance_m);
  EXPECT_LT(error.tail<3>().norm(), kTolerance_rad);
}

/// From rest to 1.6 m/s: a pose that belongs to the middle of the sweep instead of its stamp is 8
/// cm off.
TEST_P(ScanOdometries, PosesAreThoseOfTheStamps) {
  constexpr double kRest_s = 0.4, kAcceleration_m_s2 = 2.0, kSpeed_m_s = 1.6, kTolerance_m = 0.05;
  const auto drive = [](double t_s) {
    const double t = std::max(t_s - kRest_s, 0.0), ramp_s = kSpeed_m_s / kAcceleration_m_s2;
    const double way_m =
        t < ramp_s ? 0.5 * kAcceleration_m_s2 * t * t : kSpeed_m_s * (t - 0.5 * ramp_s);
    return Pose3::translation(way_m, 0.0, 0.5);
  };
  const auto odometry = scanOdometries().make(GetParam(), OdometryParams());
  test::LidarModel lidar;
  std::mt19937_64 random(5);
  for (int i = 0; i <= 15; ++i) {
    const double t_s = 0.1 * i;
    const auto estimate = odometry->update(
        test::sweep(test::furnishedRoom(), lidar, drive, t_s, random), std::nullopt);
    ASSERT_TRUE(estimate) << "scan " << i;
    if (t_s < 1.3) continue;
    const Pose3 T_first_now = drive(0.0).inverse() * drive(t_s);
    EXPECT_LT((estimate->T_odom_base.t - T_first_now.t).norm(), kTolerance_m) << t_s;
  }
}

TEST_P(ScanOdometries, GivesTheSameBytesWithOneAndTwoThreads) {
  const auto one = run(GetParam(), 1), two = run(GetParam(), 2);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(
        std::memcmp(one[i].T_odom_base.R.data(), two[i].T_odom_base.R.data(), sizeof(Matrix3)), 0);
    EXPECT_EQ(
        std::memcmp(one[i].T_odom_base.t.data(), two[i].T_odom_base.t.data(), sizeof(Vector3)), 0);
    EXPECT_EQ(std::memcmp(one[i].covariance.data(), two[i].covariance.data(), sizeof(Matrix6)), 0);
  }
}

TEST_P(ScanOdometries, RefusesEmptyScansAndRepeatedStamps) {
  OdometryParams params;
  const auto odometry = scanOdometries().make(GetParam(), params);
  EXPECT_EQ(odometry->update(Scan(), std::nullopt).error(), OdometryFailure::kTooFewPoints);
  test::LidarModel lidar;
  std::mt19937_64 random(2);
  const Scan scan = test::sweep(test::furnishedRoom(), lidar, test::atRest(), 0.0, random);
  ASSERT_TRUE(odometry->update(scan, std::nullopt));
  EXPECT_EQ(odometry->update(scan, std::nullopt).error(), OdometryFailure::kStampNotIncreasing);
}

INSTANTIATE_TEST_SUITE_P(All, ScanOdometries, ::testing::ValuesIn(scanOdometries().names()));

TEST(ScanOdometryKinds, OnlyThoseThatDeskewMeasureTheMotionInASweep) {
  OdometryParams params;
  EXPECT_TRUE(scanOdometries().make("local_map", params)->measuresSweepMotion());
  EXPECT_FALSE(scanOdometries().make("keyframe_gicp", params)->measuresSweepMotion());
  params.local_map.deskew = false;
  EXPECT_FALSE(scanOdometries().make("local_map", params)->measuresSweepMotion());
}

TEST(OdometryParams, RoundTripThroughYaml) {
  OdometryParams params;
  params.local_map.registration.kernel_m = 0.07;
  params.keyframe_gicp.keyframe_translation_m = 0.9;
  ConfigLoader loader;
  loader.addText(toYaml(params), "dump");
  OdometryParams read;
  load(loader, read);
  EXPECT_EQ(toYaml(read), toYaml(params));
  EXPECT_DOUBLE_EQ(read.local_map.registration.kernel_m, 0.07);
}

TEST(OdometryParams, AnUnknownMethodIsAConfigurationError) {
  EXPECT_THROW(scanOdometries().make("none", OdometryParams()), ConfigError);
}

}  // namespace
}  // namespace dynemo
