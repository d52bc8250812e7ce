#pragma once

#include <unordered_set>
#include <vector>

#include "dynemo/core/voxel.h"

namespace dynemo {

/// The first point of each voxel; Point has a float `p_map` [m].
template <class Point>
std::vector<Point> thinned(const std::vector<Point>& points, float voxel_m) {
  std::unordered_set<Eigen::Vector3i, VoxelHash> seen;
  std::vector<Point> kept;
  for (const Point& point : points) {
    const auto voxel = voxelOf(point.p_map, voxel_m);
    if (voxel && seen.insert(*voxel).second) kept.push_back(point);
  }
  return kept;
}

/// Thinned by a voxel that grows until the points are few enough.
template <class Point>
std::vector<Point> withinBudget(std::vector<Point> points, double voxel_m, std::size_t max_points) {
  auto size_m = static_cast<float>(voxel_m);
  points = thinned(points, size_m);
  while (points.size() > max_points) {
    size_m *= 1.5f;
    points = thinned(points, size_m);
  }
  return points;
}

}  // namespace dynemo
