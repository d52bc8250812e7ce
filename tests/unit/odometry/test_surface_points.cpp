#include "dynemo/odometry/surface_points.h"

#include <gtest/gtest.h>

#include "synthetic_world.h"

namespace dynemo {
namespace {

Scan roomScan(int rows = 32, int columns = 512) {
  test::LidarModel lidar;
  lidar.rows = rows;
  lidar.columns = columns;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(2);
  return test::sweep(test::furnishedRoom(), lidar, test::atRest(), 0.0, random);
}

SurfacePoints extract(const Scan& scan, std::span<const std::uint32_t> ignored = {},
                      const SurfaceParams& params = {}) {
  WorkerPool pool(1);
  return extractSurface(scan, {}, 0.0, {}, ignored, params, pool);
}

TEST(SurfacePoints, NormalsOfWallsFloorAndCeilingFaceTheSensor) {
  const Scan scan = roomScan();
  const SurfacePoints surface = extract(scan);
  ASSERT_GT(surface.size(), 800U);
  const Pose3 T_world_base = test::atRest()(0.0);
  constexpr double kMaxAngleCosine = 0.98;
  int walls = 0, right = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const Eigen::Vector3f ray = surface.points[i] - scan.T_base_lidar.t.cast<float>();
    EXPECT_LE(ray.dot(surface.normals[i]), 0.0F);
    EXPECT_NEAR(surface.normals[i].norm(), 1.0F, 1e-4F);
    const Vector3 p = T_world_base * surface.points[i].cast<double>();
    if (p.x() > -5.9 || std::abs(p.y()) > 4.0 || std::abs(p.z() - 1.5) > 1.0) continue;
    ++walls;
    right += (T_world_base.R * surface.normals[i].cast<double>()).x() > kMaxAngleCosine ? 1 : 0;
  }
  ASSERT_GT(walls, 20);
  EXPECT_GT(right, 0.95 * walls);
}

TEST(SurfacePoints, OnePointPerLeaf) {
  SurfaceParams params;
  const SurfacePoints surface = extract(roomScan(), {}, params);
  params.leaf_m = 0.5;
  params.normal_radius_m = 1.0;
  const SurfacePoints coarse = extract(roomScan(), {}, params);
  EXPECT_LT(coarse.size(), surface.size() / 2);
}

TEST(SurfacePoints, IgnoredAndDistantPointsTakeNoPart) {
  const Scan scan = roomScan();
  PointIndices front;
  for (std::uint32_t i = 0; i < scan.cloud.size(); ++i) {
    if (scan.cloud.points[i].x() > 0.0F) front.push_back(i);
  }
  for (const Eigen::Vector3f& p : extract(scan, front).points) EXPECT_LT(p.x(), 0.2F);
  SurfaceParams params;
  params.max_range_m = 3.0;
  const SurfacePoints near = extract(scan, {}, params);
  ASSERT_GT(near.size(), 50U);
  for (const Eigen::Vector3f& p : near.points) {
    EXPECT_LT((p - scan.T_base_lidar.t.cast<float>()).norm(), 3.01F);
  }
}

TEST(SurfacePoints, ASingleScanLineIsNoSurface) {
  Scan scan = roomScan(1, 4096);
  ASSERT_GT(scan.cloud.size(), 3000U);
  EXPECT_EQ(extract(scan).size(), 0U);
}

TEST(SurfacePoints, AnEmptyScanGivesNone) { EXPECT_EQ(extract(Scan()).size(), 0U); }

TEST(SurfacePoints, TimesAreAveragedRelativeToTheReference) {
  Scan scan = roomScan();
  const std::vector<float> times_s(scan.cloud.size(), 0.03F);
  WorkerPool pool(1);
  const SurfacePoints surface = extractSurface(scan, times_s, 0.05, {}, {}, {}, pool);
  ASSERT_TRUE(surface.timed());
  for (const float t : surface.time_s) EXPECT_NEAR(t, -0.02F, 1e-6F);
}

}  // namespace
}  // namespace dynemo
