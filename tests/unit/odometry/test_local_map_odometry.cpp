#include "dynemo/odometry/local_map_odometry.h"

#include <gtest/gtest.h>

#include <cstring>

#include "synthetic_world.h"

namespace dynemo {
namespace {

using test::LidarModel;
using test::Trajectory;
using test::World;

struct Drive {
  std::vector<Pose3> truth;
  std::vector<OdometryEstimate> estimates;
  int lost = 0;

  double ate_m() const {
    std::vector<Pose3> poses;
    for (const OdometryEstimate& e : estimates) poses.push_back(e.T_odom_base);
    return test::absoluteTrajectoryError(truth, poses);
  }
};

Drive drive(const World& world, const LidarModel& lidar, const Trajectory& T_world_base,
            double seconds, double rate_hz, const OdometryParams& params = {}) {
  const auto odometry = makeLocalMapOdometry(params);
  std::mt19937_64 random(11);
  Drive driven;
  for (int i = 0; i / rate_hz < seconds; ++i) {
    const Scan scan = test::sweep(world, lidar, T_world_base, i / rate_hz, random);
    const auto estimate = odometry->update(scan, std::nullopt);
    if (!estimate) {
      ++driven.lost;
      continue;
    }
    driven.truth.push_back(T_world_base(i / rate_hz));
    driven.estimates.push_back(*estimate);
  }
  return driven;
}

/// ±4° and ±4 cm at 2 Hz with the distortion of 10 Hz sweeps, from constant velocity alone.
TEST(LocalMapOdometry, HandHeldMotionWithinOneAndAHalfCentimetres) {
  const Drive driven = drive(test::furnishedRoom(), LidarModel(), test::handHeldWalk(), 8.0, 10.0);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.ate_m(), 0.015);
}

TEST(LocalMapOdometry, DeskewIsWhatMakesHandHeldMotionWork) {
  OdometryParams params;
  params.local_map.deskew = false;
  const Drive driven =
      drive(test::furnishedRoom(), LidarModel(), test::handHeldWalk(), 3.0, 10.0, params);
  EXPECT_GT(driven.ate_m(), 0.015);
}

TEST(LocalMapOdometry, SmoothMotionWithDistortion) {
  LidarModel lidar;
  lidar.rows = 32;
  const Drive driven = drive(test::furnishedRoom(), lidar, test::wheeledDrive(), 5.0, 10.0);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.ate_m(), 0.01);
  EXPECT_TRUE(driven.estimates.front().T_odom_base.t.isZero());
}

/// Rings 2° apart within ±15° see the floor as single lines only, which lie close together over
/// many sweeps.
TEST(LocalMapOdometry, SixteenRingsHoldTheHeight) {
  LidarModel lidar;
  lidar.rows = 16;
  lidar.vertical_fov_rad = 0.524;
  const Drive driven = drive(test::furnishedRoom(), lidar, test::handHeldWalk(), 12.0, 10.0);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.ate_m(), 0.1);
}

TEST(LocalMapOdometry, ScansOfOneInstantAtALowRate) {
  LidarModel lidar;
  lidar.rows = 32;
  lidar.columns = 512;
  lidar.sweep_s = 0.0;
  const Drive driven = drive(test::furnishedRoom(), lidar, test::wheeledDrive(), 8.0, 5.0);
  EXPECT_EQ(driven.lost, 0);
  EXPECT_LT(driven.ate_m(), 0.003);
}

TEST(LocalMapOdometry, AtRestItStaysForAMinute) {
  LidarModel lidar;
  lidar.rows = 32;
  lidar.columns = 512;
  const Drive driven = drive(test::furnishedRoom(), lidar, test::atRest(), 60.0, 5.0);
  EXPECT_EQ(driven.lost, 0);
  constexpr double kMaxDrift_m = 0.01, kMaxDrift_rad = 0.05 * 3.14159265 / 180.0;
  const Pose3 drift =
      driven.estimates[20].T_odom_base.inverse() * driven.estimates.back().T_odom_base;
  EXPECT_LT(drift.t.norm(), kMaxDrift_m);
  EXPECT_LT(rotationAngle(drift), kMaxDrift_rad);
  EXPECT_LT(driven.ate_m(), kMaxDrift_m);
}

TEST(LocalMapOdometry, ThePosesAreTheChainOfTheSteps) {
  const Drive driven = drive(test::furnishedRoom(), LidarModel(), test::handHeldWalk(), 1.5, 10.0);
  Pose3 T_odom_base;
  for (const OdometryEstimate& e : driven.estimates) {
    T_odom_base = T_odom_base * e.T_prev_base;
    EXPECT_LT(local(T_odom_base, e.T_odom_base).norm(), 1e-9);
    EXPECT_LT((e.T_odom_base.R.transpose() * e.T_odom_base.R - Matrix3::Identity()).norm(), 1e-12);
  }
}

/// Nothing shows the motion along it: the log carries it.
TEST(LocalMapOdometry, AnEndlessCorridorIsReportedAndCarriedByTheRawlogsOdometry) {
  const auto odometry = makeLocalMapOdometry({});
  LidarModel lidar;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(3);
  const Trajectory truth = test::straight(1.0);
  for (int i = 0; i < 12; ++i) {
    const double t = 0.1 * i;
    const Scan scan = test::sweep(test::endlessCorridor(), lidar, truth, t, random);
    const auto estimate = odometry->update(scan, OdometryState{truth(t), std::nullopt});
    ASSERT_TRUE(estimate);
    if (i == 0) continue;
    EXPECT_EQ(estimate->diagnostics.degenerate_directions.cols(), 1);
    EXPECT_NEAR(estimate->T_prev_base.t.x(), 0.1, 0.005);
    EXPECT_GT(std::sqrt(estimate->covariance(0, 0)), 0.015) << "as uncertain as the prediction";
    EXPECT_LT(std::sqrt(estimate->covariance(1, 1)), 0.005);
  }
}

TEST(LocalMapOdometry, IgnoredPointsDoNotInfluenceTheEstimate) {
  LidarModel lidar;
  lidar.rows = 32;
  lidar.columns = 512;
  lidar.sweep_s = 0.0;
  // A crowd's worth of points that move with the robot, appended to every scan.
  const auto withCompany = [](Scan scan, PointIndices& company) {
    for (int i = 0; i < 4000; ++i) {
      company.push_back(static_cast<std::uint32_t>(scan.cloud.size()));
      scan.cloud.points.emplace_back(1.5F, -1.0F + 0.05F * static_cast<float>(i % 40),
                                     -0.8F + 0.02F * static_cast<float>(i / 40));
    }
    return scan;
  };
  const auto alone = makeLocalMapOdometry({}), accompanied = makeLocalMapOdometry({}),
             misled = makeLocalMapOdometry({});
  std::mt19937_64 random(4);
  for (int i = 0; i < 6; ++i) {
    const Scan scan =
        test::sweep(test::furnishedRoom(), lidar, test::wheeledDrive(), 0.1 * i, random);
    PointIndices company;
    const Scan crowded = withCompany(scan, company);
    const auto a = alone->update(scan, std::nullopt);
    const auto b = accompanied->update(crowded, std::nullopt, company);
    const auto c = misled->update(crowded, std::nullopt);
    ASSERT_TRUE(a && b && c);
    EXPECT_EQ(a->T_odom_base.t, b->T_odom_base.t);
    if (i > 0) {
      EXPECT_NE(a->T_odom_base.t, c->T_odom_base.t);
    }
  }
}

class LocalMapFailures : public ::testing::Test {
 protected:
  Scan at(double t, const Trajectory& trajectory = test::wheeledDrive()) {
    LidarModel lidar;
    lidar.rows = 32;
    lidar.columns = 512;
    lidar.sweep_s = 0.0;
    return test::sweep(test::furnishedRoom(), lidar, trajectory, t, random_);
  }
  std::mt19937_64 random_{9};
  std::unique_ptr<ScanOdometry> odometry_ = makeLocalMapOdometry({});
};

TEST_F(LocalMapFailures, EmptyAndTinyScansAreRefusedAndForgotten) {
  EXPECT_EQ(odometry_->update(Scan(), std::nullopt).error(), OdometryFailure::kTooFewPoints);
  ASSERT_TRUE(odometry_->update(at(0.0), std::nullopt));
  Scan tiny = at(0.1);
  tiny.cloud.points.resize(20);
  EXPECT_EQ(odometry_->update(tiny, std::nullopt).error(), OdometryFailure::kTooFewPoints);
  const auto next = odometry_->update(at(0.2), std::nullopt);
  ASSERT_TRUE(next);
  const Pose3 expected = test::wheeledDrive()(0.0).inverse() * test::wheeledDrive()(0.2);
  EXPECT_LT((next->T_odom_base.t - expected.t).norm(), 0.01);
}

TEST_F(LocalMapFailures, RepeatedAndEarlierStampsAreRefused) {
  ASSERT_TRUE(odometry_->update(at(1.0), std::nullopt));
  EXPECT_EQ(odometry_->update(at(1.0), std::nullopt).error(), OdometryFailure::kStampNotIncreasing);
  EXPECT_EQ(odometry_->update(at(0.5), std::nullopt).error(), OdometryFailure::kStampNotIncreasing);
  EXPECT_TRUE(odometry_->update(at(1.1), std::nullopt));
}

TEST_F(LocalMapFailures, AfterAGapTheScanIsFoundAgain) {
  for (const double t : {0.0, 0.1, 0.2}) ASSERT_TRUE(odometry_->update(at(t), std::nullopt));
  const Trajectory stopped = [](double) { return test::wheeledDrive()(0.3); };
  const auto after = odometry_->update(at(100.0, stopped), std::nullopt);
  ASSERT_TRUE(after);
  const Pose3 expected = test::wheeledDrive()(0.0).inverse() * stopped(0);
  EXPECT_LT((after->T_odom_base.t - expected.t).norm(), 0.01);
}

TEST_F(LocalMapFailures, InAnotherPlaceTheMapIsBegunAnewWithALargeUncertainty) {
  OdometryParams params;
  params.local_map.max_lost_scans = 3;
  odometry_ = makeLocalMapOdometry(params);
  ASSERT_TRUE(odometry_->update(at(0.0), std::nullopt));
  ASSERT_TRUE(odometry_->update(at(0.1), std::nullopt));
  const auto elsewhere = [&](double t) {
    LidarModel lidar;
    lidar.sweep_s = 0.0;
    World hall{{{Pose3::translation(0, 0, 20), Vector3(18, 14, 20)}}};
    Scan scan = test::sweep(
        hall, lidar, [](double) { return Pose3::translation(1, 2, 9); }, t, random_);
    return odometry_->update(scan, std::nullopt);
  };
  EXPECT_FALSE(elsewhere(0.2));
  EXPECT_FALSE(elsewhere(0.3));
  const auto restarted = elsewhere(0.4);
  ASSERT_TRUE(restarted);
  EXPECT_TRUE(restarted->restarted);
  EXPECT_GT(restarted->covariance(0, 0), 0.04);
  const auto next = elsewhere(0.5);
  ASSERT_TRUE(next);
  EXPECT_FALSE(next->restarted);
}

}  // namespace
}  // namespace dynemo
