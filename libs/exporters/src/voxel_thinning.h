#pragma once

#include <Eigen/Core>
#include <unordered_set>
#include <vector>

namespace dynemo {

/// Membership only; nothing is read out in its order.
struct VoxelHash {
  std::size_t operator()(const Eigen::Vector3i& v) const {
    return static_cast<std::size_t>(v.x()) * 73856093u ^
           static_cast<std::size_t>(v.y()) * 19349669u ^
           static_cast<std::size_t>(v.z()) * 83492791u;
  }
};

/// The first point of each voxel; Point has a float `p_map` [m].
template <class Point>
std::vector<Point> thinned(const std::vector<Point>& points, float voxel_m) {
  std::unordered_set<Eigen::Vector3i, VoxelHash> seen;
  std::vector<Point> kept;
  // Beyond this a float cannot be told from its neighbour voxel anyway, and the index would
  // overflow.
  constexpr float kFarthest = 1e6f;
  for (const Point& point : points) {
    const Eigen::Vector3f scaled = point.p_map / voxel_m;
    if (!(scaled.cwiseAbs().maxCoeff() < kFarthest)) continue;
    const Eigen::Vector3i voxel = scaled.array().floor().template cast<int>();
    if (seen.insert(voxel).second) kept.push_back(point);
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
