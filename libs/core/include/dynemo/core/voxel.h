#pragma once

#include <Eigen/Core>
#include <optional>

namespace dynemo {

/// For unordered containers of voxels: membership and look-up only, nothing is read out in their
/// order.
struct VoxelHash {
  std::size_t operator()(const Eigen::Vector3i& v) const {
    return static_cast<std::size_t>(v.x()) * 73856093u ^
           static_cast<std::size_t>(v.y()) * 19349669u ^
           static_cast<std::size_t>(v.z()) * 83492791u;
  }
};

/// The voxel of a point; empty where a float cannot tell voxels apart and an index would overflow.
inline std::optional<Eigen::Vector3i> voxelOf(const Eigen::Vector3f& p, float voxel_m) {
  constexpr float kFarthest = 1e6f;
  const Eigen::Vector3f scaled = p / voxel_m;
  if (!(scaled.cwiseAbs().maxCoeff() < kFarthest)) return std::nullopt;
  return scaled.array().floor().cast<int>();
}

}  // namespace dynemo
