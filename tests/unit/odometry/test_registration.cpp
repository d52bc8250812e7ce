#include "dynemo/odometry/registration.h"

#include <gtest/gtest.h>

#include <cstring>

#include "dynemo/odometry/voxel_hash_map.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

constexpr double kTranslationTolerance_m = 0.003;
constexpr double kRotationTolerance_rad = 0.001;

SurfacePoints surfaceAt(const test::World& world, const Pose3& T_world_base, std::uint64_t seed) {
  test::LidarModel lidar;
  lidar.rows = 64;
  lidar.columns = 512;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(seed);
  const Scan scan = test::sweep(
      world, lidar, [&](double) { return T_world_base; }, 0.0, random);
  WorkerPool pool(1);
  return extractSurface(scan, {}, 0.0, {}, {}, {}, pool);
}

/// Two scans of the room, their surfaces and the map of the first one, optionally moved away from
/// the origin.
class RegistrationTest : public ::testing::Test {
 protected:
  const Pose3 T_world_a_ = Pose3::fromYawPitchRoll(-1, -1, 0.8, 0.4, 0.02, 0);
  const Pose3 T_world_b_ = Pose3::fromYawPitchRoll(-0.8, -0.9, 0.82, 0.5, 0, -0.03);
  const SurfacePoints a_ = surfaceAt(test::furnishedRoom(), T_world_a_, 1);
  const SurfacePoints b_ = surfaceAt(test::furnishedRoom(), T_world_b_, 2);

  static VoxelHashMap mapOf(const SurfacePoints& surface, const Pose3& T_map_base) {
    VoxelHashMap map({});
    const Eigen::Matrix3f R = T_map_base.R.cast<float>();
    for (std::size_t i = 0; i < surface.size(); ++i) {
      map.insert(R * surface.points[i] + T_map_base.t.cast<float>(), R * surface.normals[i]);
    }
    return map;
  }

  static Expected<Registration, OdometryFailure> match(const SurfacePoints& scan,
                                                       const VoxelHashMap& map,
                                                       const Pose3& T_map_guess, int threads = 1,
                                                       const RegistrationParams& params = {}) {
    RegistrationPrior prior;
    prior.T_target_base = T_map_guess;
    WorkerPool pool(threads);
    return registerScan(scan, map, prior, params, pool);
  }

  static void expectNear(const Pose3& T_expected,
                         const Expected<Registration, OdometryFailure>& found) {
    ASSERT_TRUE(found) << toString(found.error());
    const Vector6 error = local(T_expected, found->T_target_base);
    EXPECT_LT(error.head<3>().norm(), kTranslationTolerance_m);
    EXPECT_LT(error.tail<3>().norm(), kRotationTolerance_rad);
    EXPECT_GT(found->diagnostics.inlier_ratio, 0.7);
    EXPECT_EQ(found->diagnostics.degenerate_directions.cols(), 0);
  }
};

TEST_F(RegistrationTest, Forward) {
  expectNear(T_world_a_.inverse() * T_world_b_, match(b_, mapOf(a_, Pose3()), Pose3()));
}

TEST_F(RegistrationTest, Inverse) {
  expectNear(T_world_b_.inverse() * T_world_a_, match(a_, mapOf(b_, Pose3()), Pose3()));
}

TEST_F(RegistrationTest, Shifted) {
  const Pose3 T_map_a = Pose3::fromYawPitchRoll(120, -80, 7, 2.1, 0.3, -0.2);
  expectNear(T_map_a * T_world_a_.inverse() * T_world_b_, match(b_, mapOf(a_, T_map_a), T_map_a));
}

TEST_F(RegistrationTest, PointToPlane) {
  RegistrationParams params;
  params.metric = RegistrationMetric::kPlane;
  expectNear(T_world_a_.inverse() * T_world_b_, match(b_, mapOf(a_, Pose3()), Pose3(), 1, params));
}

TEST_F(RegistrationTest, TheCovarianceCoversTheError) {
  const auto found = match(b_, mapOf(a_, Pose3()), Pose3());
  ASSERT_TRUE(found);
  const Vector6 error = local(T_world_a_.inverse() * T_world_b_, found->T_target_base);
  const Matrix6 covariance = found->covariance.topLeftCorner<6, 6>();
  constexpr double kChiSquared6At999 = 22.5;
  // Both scans share the map's discretisation, which the Hessian does not know: three times the
  // deviation.
  EXPECT_LT(error.dot(covariance.ldlt().solve(error)), 9.0 * kChiSquared6At999);
  EXPECT_LT(std::sqrt(covariance.topLeftCorner<3, 3>().trace()), 0.02);
}

TEST_F(RegistrationTest, TheSameBytesWithAnyNumberOfThreads) {
  const VoxelHashMap map = mapOf(a_, Pose3());
  const auto one = match(b_, map, Pose3(), 1), three = match(b_, map, Pose3(), 3);
  ASSERT_TRUE(one && three);
  EXPECT_EQ(
      std::memcmp(one->T_target_base.R.data(), three->T_target_base.R.data(), sizeof(Matrix3)), 0);
  EXPECT_EQ(
      std::memcmp(one->T_target_base.t.data(), three->T_target_base.t.data(), sizeof(Vector3)), 0);
  EXPECT_EQ(std::memcmp(one->covariance.data(), three->covariance.data(), sizeof(MotionCovariance)),
            0);
}

TEST_F(RegistrationTest, ThePriorCarriesWhatACorridorDoesNotShow) {
  const test::World corridor = test::endlessCorridor();
  const SurfacePoints a = surfaceAt(corridor, Pose3::translation(0, 0.2, 0.8), 1);
  const SurfacePoints b = surfaceAt(corridor, Pose3::translation(0.13, 0.25, 0.8), 2);
  RegistrationPrior prior;
  prior.T_target_base = Pose3::translation(0.1, 0, 0);
  prior.covariance = 0.04 * Matrix6::Identity();
  WorkerPool pool(1);
  const auto found = registerScan(b, mapOf(a, Pose3()), prior, {}, pool);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->diagnostics.degenerate_directions.cols(), 1);
  EXPECT_GT(std::abs(found->diagnostics.degenerate_directions(0, 0)), 0.99);
  EXPECT_NEAR(found->T_target_base.t.x(), 0.1, 0.01) << "along the corridor as predicted";
  EXPECT_NEAR(found->T_target_base.t.y(), 0.05, 0.005) << "across it as seen";
  EXPECT_NEAR(found->covariance(0, 0), 0.04, 0.004);
  EXPECT_LT(found->covariance(1, 1), 1e-4);
}

TEST_F(RegistrationTest, FailuresAreValues) {
  SurfacePoints tiny;
  const VoxelHashMap map = mapOf(a_, Pose3());
  EXPECT_EQ(match(tiny, map, Pose3()).error(), OdometryFailure::kTooFewPoints);
  EXPECT_EQ(match(b_, map, Pose3::translation(500, 0, 0)).error(), OdometryFailure::kNoOverlap);
  EXPECT_EQ(match(b_, VoxelHashMap({}), Pose3()).error(), OdometryFailure::kNoOverlap);
}

}  // namespace
}  // namespace dynemo
