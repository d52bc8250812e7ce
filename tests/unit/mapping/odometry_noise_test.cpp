#include "dynemo/mapping/odometry_noise.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "dynemo/core/noise.h"

namespace dynemo {
namespace {

OdometryNoiseParams withoutJitter() {
  OdometryNoiseParams p;
  p.jitter_m = p.jitter_rad = 1e-9;
  return p;
}

TEST(OdometryNoise, RecordedGrowthIsRecovered) {
  const Pose3 T_odom_a = Pose3::fromYawPitchRoll(3, -2, 0.1, 1.2, 0.02, -0.01);
  const Pose3 T_a_b = Pose3::fromYawPitchRoll(1.0, 0.2, 0, 0.4, 0, 0);
  const Matrix6 Q = isotropicCovariance(0.03, 0.01);
  const Matrix6 cov_a = isotropicCovariance(0.2, 0.05);
  const Matrix6 A = composeJacobianLeft(T_a_b);
  const OdometryState a{T_odom_a, cov_a}, b{T_odom_a * T_a_b, A * cov_a * A.transpose() + Q};
  OdometryNoiseParams p = withoutJitter();
  p.systematic_per_sqrt_m = 0.0;
  EXPECT_LT((relativeOdometryCovariance(a, b, 1, 0.4, p) - Q).norm(), 1e-9);
  p.systematic_per_sqrt_m = 0.02;
  const Matrix6 excess = relativeOdometryCovariance(a, b, 4, 0.4, p) - Q;
  EXPECT_NEAR(excess(0, 0), 0.0016, 1e-9);
  EXPECT_NEAR(excess(5, 5), 0.0, 1e-9);
}

TEST(OdometryNoise, AShrinkingRecordedCovarianceStaysPositiveDefinite) {
  Matrix6 cov_b = isotropicCovariance(0.1, 0.05);
  cov_b(0, 0) = 0.5;  // grows along x, shrinks elsewhere
  const OdometryState a{Pose3(), isotropicCovariance(0.2, 0.05)}, b{Pose3(), cov_b};
  const Matrix6 cov = relativeOdometryCovariance(a, b, 1, 0, OdometryNoiseParams());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(cov).eigenvalues().minCoeff(), 0.0);
}

TEST(OdometryNoise, TheModelGrowsWithDistanceAndAngle) {
  const OdometryState s{Pose3::translation(0, 0, 0.1), std::nullopt};
  const auto p = withoutJitter();
  const Matrix6 one = relativeOdometryCovariance(s, s, 1.0, 0.0, p),
                four = relativeOdometryCovariance(s, s, 4.0, 0.0, p);
  EXPECT_NEAR(four(0, 0) / one(0, 0), 4.0, 1e-6);
  EXPECT_NEAR(one(0, 0), p.translation_per_sqrt_m * p.translation_per_sqrt_m, 1e-9);
  EXPECT_GT(relativeOdometryCovariance(s, s, 1.0, 1.0, p)(5, 5), one(5, 5));
}

TEST(OdometryNoise, PlanarOdometryIsTrustedLess) {
  const auto p = withoutJitter();
  const OdometryState planar{Pose3::fromYawPitchRoll(1, 2, 0, 0.3, 0, 0), std::nullopt};
  const OdometryState spatial{Pose3::fromYawPitchRoll(1, 2, 0.001, 0.3, 0.001, 0), std::nullopt};
  const double ratio = relativeOdometryCovariance(planar, planar, 1, 0, p)(0, 0) /
                       relativeOdometryCovariance(spatial, spatial, 1, 0, p)(0, 0);
  EXPECT_NEAR(ratio, p.planar_scale * p.planar_scale, 1e-9);
}

TEST(OdometryNoise, AtRestTheJitterRemains) {
  const OdometryState s{Pose3(), isotropicCovariance(0.1, 0.1)};
  const OdometryNoiseParams p;
  EXPECT_NEAR(relativeOdometryCovariance(s, s, 0, 0, p)(0, 0), p.jitter_m * p.jitter_m, 1e-12);
}

TEST(OdometryNoise, DistortionGrowsWithTheMotionDuringASweep) {
  const SweepDistortionParams p;
  EXPECT_TRUE(distortionCovariance(Vector6::Zero(), p).isZero());
  Vector6 motion = Vector6::Zero();
  motion[1] = 0.2;
  const Matrix6 driven = distortionCovariance(motion, p);
  EXPECT_NEAR(std::sqrt(driven(0, 0)), 0.2 * p.m_per_m, 1e-12);
  EXPECT_NEAR(std::sqrt(driven(5, 5)), 0.2 * p.rad_per_m, 1e-12);
  motion[5] = 0.1;
  const Matrix6 both = distortionCovariance(motion, p);
  EXPECT_NEAR(both(0, 0) - driven(0, 0), std::pow(0.1 * p.m_per_rad, 2), 1e-12);
  EXPECT_NEAR(both(5, 5) - driven(5, 5), std::pow(0.1 * p.rad_per_rad, 2), 1e-12);
}

TEST(OdometryNoise, MissingOdometryIsAlmostFree) {
  const OdometryNoiseParams p;
  const Matrix6 cov = relativeOdometryCovariance(std::nullopt, OdometryState{}, 0, 0, p);
  EXPECT_NEAR(cov(0, 0), p.missing_sigma_m * p.missing_sigma_m, 1e-12);
}

Scan cube(double spacing_m) {
  Scan scan;
  scan.T_base_lidar = Pose3::fromYawPitchRoll(0.1, 0.2, 0.5, 0.3, 0, 0);
  for (double x = 0; x < 4; x += spacing_m) {
    for (double y = 0; y < 4; y += spacing_m) {
      scan.cloud.points.push_back(
          (scan.T_base_lidar.inverse() * Vector3(x, y, 0.1 * x * y)).cast<float>());
    }
  }
  return scan;
}

TEST(ScanFitness, IsZeroUnderTheTruePoseAndTheSquaredOffsetNearby) {
  const Scan scan = cube(0.5);
  EXPECT_NEAR(scanFitness(scan, scan, Pose3()), 0.0, 1e-9);
  EXPECT_NEAR(scanFitness(scan, scan, Pose3::translation(0.1, 0, 0)), 0.01, 1e-4);
  EXPECT_TRUE(std::isinf(scanFitness(scan, Scan(), Pose3())));
}

TEST(ScanFitness, CovarianceRunsFromTheSmallestToTheLargest) {
  const OdometryNoiseParams p;
  EXPECT_NEAR(std::sqrt(fitnessCovariance(0.0, p)(0, 0)), p.fitness_min_sigma_m, 1e-12);
  EXPECT_NEAR(std::sqrt(fitnessCovariance(p.fitness_max_m2, p)(5, 5)), p.fitness_max_sigma_rad,
              1e-12);
  EXPECT_NEAR(std::sqrt(fitnessCovariance(std::numeric_limits<double>::infinity(), p)(0, 0)),
              p.fitness_max_sigma_m, 1e-12);
}

}  // namespace
}  // namespace dynemo
