#include "dynemo/odometry/voxel_hash_map.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <vector>

namespace dynemo {
namespace {

using Eigen::Vector3f;

VoxelHashMapParams roomyParams() {
  VoxelHashMapParams params;
  params.max_points_per_cell = 64;
  params.min_spacing_m = 0.0;
  return params;
}

std::vector<Vector3f> randomPoints(int count, float half_size_m) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> uniform(-half_size_m, half_size_m);
  std::vector<Vector3f> points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(uniform(random), uniform(random), uniform(random));
  return points;
}

/// The nearest of those points whose cell is among the searched ones, by brute force.
std::optional<Vector3f> nearestOf(const std::vector<Vector3f>& points, const Vector3f& query,
                                  const CorrespondenceGate& gate) {
  const CellCoordinates home = cellOf(query, 2.0F);
  float nearest2 = gate.max_distance_m * gate.max_distance_m;
  std::optional<Vector3f> nearest;
  for (const Vector3f& p : points) {
    const CellCoordinates steps = (cellOf(p, 2.0F) - home).cwiseAbs();
    const bool searched = gate.wide ? steps.maxCoeff() <= 1 : steps.sum() <= 1;
    if (!searched || (p - query).squaredNorm() >= nearest2) continue;
    nearest2 = (p - query).squaredNorm();
    nearest = p;
  }
  return nearest;
}

TEST(VoxelHashMap, FindsTheNearestPointOfTheSearchedCells) {
  VoxelHashMap map(roomyParams());
  const auto points = randomPoints(3000, 2.0F);
  const Vector3f normal = Vector3f::UnitZ();
  for (const Vector3f& p : points) map.insert(p, normal);
  ASSERT_EQ(map.points(), points.size());
  for (const bool wide : {false, true}) {
    CorrespondenceGate gate;
    gate.max_distance_m = 0.4F;
    gate.wide = wide;
    int found_count = 0;
    for (const Vector3f& query : randomPoints(500, 2.5F)) {
      const Vector3f shifted = query + Vector3f(0.01F, 0.02F, -0.01F);
      const auto expected = nearestOf(points, shifted, gate);
      Correspondence found;
      ASSERT_EQ(map.nearest(shifted, normal, gate, found), expected.has_value());
      if (!expected) continue;
      ++found_count;
      EXPECT_EQ(found.point, *expected);
    }
    EXPECT_GT(found_count, 300);
    EXPECT_LT(found_count, 500);
  }
}

TEST(VoxelHashMap, TheNormalGateChoosesTheRightFaceOfAThinWall) {
  VoxelHashMap map({});
  map.insert({0.20F, 0.1F, 0.1F}, Vector3f::UnitX());
  map.insert({0.08F, 0.1F, 0.1F}, -Vector3f::UnitX());
  EXPECT_EQ(map.points(), 2U);
  CorrespondenceGate gate;
  gate.max_distance_m = 0.5F;
  gate.min_normal_cosine = 0.5F;
  Correspondence found;
  ASSERT_TRUE(map.nearest({0.1F, 0.1F, 0.1F}, Vector3f::UnitX(), gate, found));
  EXPECT_FLOAT_EQ(found.point.x(), 0.20F);
  EXPECT_FALSE(map.nearest({0.1F, 0.1F, 0.1F}, Vector3f::UnitY(), gate, found));
}

TEST(VoxelHashMap, KeepsItsSpacingAndCapacity) {
  VoxelHashMapParams params;
  params.max_points_per_cell = 3;
  params.min_spacing_m = 0.1;
  VoxelHashMap map(params);
  map.insert({0.10F, 0.1F, 0.1F}, Vector3f::UnitZ());
  map.insert({0.15F, 0.1F, 0.1F}, Vector3f::UnitZ());
  EXPECT_EQ(map.points(), 1U) << "closer than the spacing";
  for (float x : {0.22F, 0.34F, 0.46F}) map.insert({x, 0.1F, 0.1F}, Vector3f::UnitZ());
  EXPECT_EQ(map.points(), 3U) << "no more than the capacity";
}

TEST(VoxelHashMap, WideSearchReachesTheCornerCells) {
  VoxelHashMap map({});
  map.insert({0.51F, 0.51F, 0.51F}, Vector3f::UnitZ());
  CorrespondenceGate gate;
  gate.max_distance_m = 0.2F;
  Correspondence found;
  EXPECT_FALSE(map.nearest({0.49F, 0.49F, 0.49F}, Vector3f::UnitZ(), gate, found));
  gate.wide = true;
  EXPECT_TRUE(map.nearest({0.49F, 0.49F, 0.49F}, Vector3f::UnitZ(), gate, found));
}

TEST(VoxelHashMap, ForgetsFarCellsOnly) {
  VoxelHashMap map({});
  map.insert({50, 0, 0}, Vector3f::UnitZ());
  map.insert({1, 0, 0}, Vector3f::UnitZ());
  map.insert({2, 0, 0}, Vector3f::UnitY());
  map.removeFartherThan(Vector3f::Zero(), 10.0);
  EXPECT_EQ(map.points(), 2U);
  Correspondence found;
  ASSERT_TRUE(map.nearest({2, 0, 0}, Vector3f::UnitY(), {}, found));
  EXPECT_EQ(found.normal, Vector3f(Vector3f::UnitY()));
  EXPECT_FALSE(map.nearest({50, 0, 0}, Vector3f::UnitZ(), {}, found));
  map.clear();
  EXPECT_EQ(map.points(), 0U);
}

}  // namespace
}  // namespace dynemo
