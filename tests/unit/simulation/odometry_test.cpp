#include "dynemo/simulation/odometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dynemo/core/noise.h"
#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

constexpr double kRate_hz = 10.0;

Pose3 truth(const RobotMotion& robot, double t_s) {
  return odometryOrigin(robot).inverse() * robot.at(t_s);
}

TEST(PoseOdometry, IsTheTruthWithoutNoise) {
  World world = smallWorld();
  world.sensors.noise = false;
  const RobotMotion robot(world.robot, world.seed);
  PoseOdometry odometry(world, robot);
  for (std::uint64_t i = 0; i < 80; ++i) {
    const double t_s = static_cast<double>(i) / kRate_hz;
    EXPECT_LT(local(truth(robot, t_s), odometry.at(i, t_s).T_odom_base).norm(), 1e-9) << t_s;
  }
}

TEST(PoseOdometry, StartsAtTheOriginLevelled) {
  const World world = smallWorld();
  const RobotMotion robot(world.robot, world.seed);
  const Pose3 T = PoseOdometry(world, robot).at(0, 0.0).T_odom_base;
  EXPECT_NEAR(T.t.norm(), 0.0, 1e-12);
  EXPECT_NEAR(std::atan2(T.R(1, 0), T.R(0, 0)), 0.0, 1e-12);
  EXPECT_NEAR(T.R(2, 0), robot.at(0.0).R(2, 0), 1e-12) << "pitch is the true one";
}

/// Mean of the normalised squared errors over many runs: 6 when the covariance is honest.
TEST(PoseOdometry, CovarianceIsHonest) {
  World world = smallWorld();
  world.robot.laps = 3;
  world.sensors.odom3d.scale_bias_sigma = 0.01;
  world.sensors.odom3d.yaw_bias_sigma_per_m_rad = 0.003;
  constexpr int kRuns = 400;
  double sum = 0.0;
  const RobotMotion robot(world.robot, 3);
  for (int run = 0; run < kRuns; ++run) {
    world.seed = run;
    PoseOdometry odometry(world, robot);
    PoseOdometry::Estimate estimate;
    for (std::uint64_t i = 0; i <= 300; i += 3)
      estimate = odometry.at(i, static_cast<double>(i) / kRate_hz);
    sum += squaredMahalanobis(local(truth(robot, 30.0), estimate.T_odom_base), estimate.covariance);
  }
  // The mean of 400 values of a χ²₆ variable spreads by √(12/400) = 0.17.
  EXPECT_NEAR(sum / kRuns, 6.0, 0.7);
}

TEST(WheelOdometry, IsTheTruthWithoutNoise) {
  World world = smallWorld();
  world.sensors.noise = false;
  const RobotMotion robot(world.robot, world.seed);
  WheelOdometry odometry(world, robot);
  for (std::uint64_t i = 0; i < 80; ++i) {
    const double t_s = static_cast<double>(i) / kRate_hz;
    const Pose3 T = truth(robot, t_s);
    const Vector3 p = odometry.at(i, t_s);
    EXPECT_LT((p.head<2>() - T.t.head<2>()).norm(), 1e-9);
    EXPECT_NEAR(p.z(), std::atan2(T.R(1, 0), T.R(0, 0)), 1e-9);
  }
}

TEST(WheelOdometry, DriftsWithNoise) {
  World world = smallWorld();
  const RobotMotion robot(world.robot, world.seed);
  WheelOdometry odometry(world, robot);
  Vector3 p = Vector3::Zero();
  for (std::uint64_t i = 0; i < 80; ++i) p = odometry.at(i, static_cast<double>(i) / kRate_hz);
  const double error_m = (p.head<2>() - truth(robot, 7.9).t.head<2>()).norm();
  EXPECT_GT(error_m, 1e-3);
  EXPECT_LT(error_m, 0.5);
}

}  // namespace
}  // namespace dynemo::simulation::test
