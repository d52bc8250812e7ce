#include "dynemo/odometry/sweep_motion.h"

#include <gtest/gtest.h>

#include "dynemo/odometry/deskew.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

const SweepMotion kMotion{{{1.2, -0.3, 0.2}, {0.4, -0.6, 0.9}}, {{2, 1, -3}, {5, -4, 3}}};

TEST(SweepMotion, TwistOfInvertsConstantTwist) {
  const SweepMotion constant{kMotion.twist, {}};
  for (const double dt_s : {-0.7, -0.05, 0.1, 1.3}) {
    const BodyTwist twist = twistOf(constant.at(dt_s), dt_s);
    EXPECT_LT((twist.vector() - kMotion.twist.vector()).norm(), 1e-9) << dt_s;
  }
}

TEST(SweepMotion, ConstantTwistComposes) {
  const SweepMotion constant{kMotion.twist, {}};
  EXPECT_LT(local(constant.at(0.3), constant.at(0.1) * constant.at(0.2)).norm(), 1e-12);
}

TEST(SweepMotion, CarrierAgreesWithTheClosedForm) {
  const Pose3 T_base_sensor = Pose3::fromYawPitchRoll(0.2, -0.1, 0.5, 0.3, 0.1, -0.2);
  const PointCarrier carrier(kMotion, T_base_sensor);
  const Vector3 p_sensor(3, -4, 1);
  constexpr double kTolerance_m = 2e-5;
  for (const double tau_s : {-0.05, 0.0, 0.03, 0.05}) {
    const Pose3 T_ref_now = T_base_sensor.inverse() * kMotion.at(tau_s) * T_base_sensor;
    const Vector3 expected = T_ref_now * p_sensor;
    const Eigen::Vector3f actual =
        carrier.toReference(static_cast<float>(tau_s), p_sensor.cast<float>());
    EXPECT_LT((actual.cast<double>() - expected).norm(), kTolerance_m) << tau_s;
  }
}

/// A distorted sweep, deskewed to any instant, equals the scan taken at that instant.
TEST(Deskew, RestoresTheScanOfOneInstant) {
  const SweepMotion steady{{{1.0, 0.2, 0}, {0.1, -0.2, 0.8}}, {}};
  const Pose3 start = Pose3::fromYawPitchRoll(-1, -1, 1, 0.3, 0, 0);
  const test::Trajectory move = [&](double t) { return start * steady.at(t); };
  test::LidarModel lidar;
  lidar.rows = 8;
  lidar.columns = 128;
  lidar.sigma_m = 0.0;
  std::mt19937_64 random(1);
  const Scan scan = test::sweep(test::furnishedRoom(), lidar, move, 0.0, random);
  constexpr double kTolerance_m = 1e-3;
  for (const double at_s : {0.0, 0.05, 0.1}) {
    const PointCloud still = deskew(scan.cloud, lidar.T_base_lidar, steady, at_s);
    ASSERT_EQ(still.size(), scan.cloud.size());
    EXPECT_TRUE(still.time_offset_s.empty());
    for (std::size_t i = 0; i < still.size(); ++i) {
      const double t = static_cast<double>(scan.cloud.time_offset_s[i]);
      const Vector3 world = move(t) * lidar.T_base_lidar * scan.cloud.points[i].cast<double>();
      const Vector3 actual = move(at_s) * lidar.T_base_lidar * still.points[i].cast<double>();
      ASSERT_LT((world - actual).norm(), kTolerance_m) << "point " << i << " to " << at_s;
    }
  }
}

TEST(Deskew, WithoutTimesNothingChanges) {
  PointCloud cloud;
  cloud.points = {{1, 2, 3}};
  EXPECT_EQ(deskew(cloud, Pose3(), kMotion, 0.0).points, cloud.points);
}

}  // namespace
}  // namespace dynemo
