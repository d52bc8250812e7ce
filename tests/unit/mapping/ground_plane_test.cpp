#include "dynemo/mapping/ground_plane.h"

#include <gtest/gtest.h>

#include <random>

namespace dynemo {
namespace {

/// Ground at `height_m` below a levelled base, a wall and a table, seen by a LiDAR that is mounted
/// askew.
Scan room(double height_m, const Matrix3& R_level_base, double noise_m = 0.01) {
  Scan scan;
  scan.T_base_lidar = Pose3::fromYawPitchRoll(0.1, 0, 0.5, 0.2, 0.05, -0.03);
  std::mt19937 rng(3);
  std::normal_distribution<double> noise(0.0, noise_m);
  const auto add = [&](const Vector3& p_level) {
    const Vector3 p_base = R_level_base.transpose() * p_level;
    scan.cloud.points.push_back((scan.T_base_lidar.inverse() * p_base).cast<float>());
  };
  for (double x = -4; x <= 4; x += 0.2) {
    for (double y = -4; y <= 4; y += 0.2) {
      add({x, y, height_m + noise(rng)});
      if (std::abs(x) < 1 && y > 1 && y < 3) add({x, y, height_m + 0.7 + noise(rng)});
    }
    for (double z = height_m; z < 2; z += 0.1) add({x, 4, z});
  }
  return scan;
}

TEST(FindGround, FindsTheFloorAmongFurniture) {
  const auto ground = findGround(room(-0.12, Matrix3::Identity()), Matrix3::Identity());
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height_m, -0.12, 0.005);
}

TEST(FindGround, LevelsATiltedBase) {
  const Matrix3 R_level_base = expSO3(Vector3(0.07, -0.05, 0.0));
  const auto ground = findGround(room(-1.25, R_level_base), R_level_base);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height_m, -1.25, 0.01);
}

TEST(FindGround, TheNormalOfATiltedGroundLevelsTheBase) {
  const Matrix3 R_level_base = expSO3(Vector3(0.06, 0.04, 0.0));
  const auto ground = findGround(room(-1.25, R_level_base), Matrix3::Identity());
  ASSERT_TRUE(ground);
  EXPECT_LT(logSO3(levelling(*ground) * R_level_base.transpose()).norm(), 0.005);
}

TEST(FindGround, NothingWithoutGround) {
  Scan scan;
  EXPECT_FALSE(findGround(scan, Matrix3::Identity()));
  for (int i = 0; i < 500; ++i)
    scan.cloud.points.emplace_back(2.0f, 0.01f * static_cast<float>(i % 50),
                                   0.02f * static_cast<float>(i / 50) - 1.0f);
  EXPECT_FALSE(findGround(scan, Matrix3::Identity()));
}

TEST(FindGround, IsDeterministic) {
  const Scan scan = room(-0.3, Matrix3::Identity());
  EXPECT_EQ(findGround(scan, Matrix3::Identity())->height_m,
            findGround(scan, Matrix3::Identity())->height_m);
}

}  // namespace
}  // namespace dynemo
