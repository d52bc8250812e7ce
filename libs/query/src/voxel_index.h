// Numbers for voxels.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "dynemo/core/voxel.h"

namespace dynemo {

/// Voxels that lie together are looked up in one dense block: the points of a scan and the
/// neighbours of a voxel mostly do.
class VoxelIndex {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  /// kNone until it is assigned.
  std::uint32_t& operator[](const Eigen::Vector3i& voxel) {
    const auto [it, added] =
        blocks_.try_emplace(blockOf(voxel), static_cast<std::uint32_t>(numbers_.size()));
    if (added) numbers_.emplace_back().fill(kNone);
    return numbers_[it->second][insideBlock(voxel)];
  }
  std::uint32_t find(const Eigen::Vector3i& voxel) const {
    const auto it = blocks_.find(blockOf(voxel));
    return it == blocks_.end() ? kNone : numbers_[it->second][insideBlock(voxel)];
  }

 private:
  static constexpr int kBits = 4, kSide = 1 << kBits;

  static Eigen::Vector3i blockOf(const Eigen::Vector3i& voxel) {
    return {voxel.x() >> kBits, voxel.y() >> kBits, voxel.z() >> kBits};
  }
  static std::size_t insideBlock(const Eigen::Vector3i& voxel) {
    const auto inside = [](int i) { return static_cast<std::size_t>(i & (kSide - 1)); };
    return (inside(voxel.x()) << (2 * kBits)) | (inside(voxel.y()) << kBits) | inside(voxel.z());
  }

  std::unordered_map<Eigen::Vector3i, std::uint32_t, VoxelHash> blocks_;
  std::vector<std::array<std::uint32_t, kSide * kSide * kSide>> numbers_;
};

}  // namespace dynemo
