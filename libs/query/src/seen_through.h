// Places where something was seen in some scans and through which others look: what stood there
// only passed by, or is gone.
//
// As the range-image and free-space tests of map cleaning (G. Kim, A. Kim, "Remove, then revert",
// IROS 2020; A. Hornung et al., "OctoMap", Autonomous Robots 2013), but with single rays instead of
// voxels or pixels, so that what a sparse scan has between its rings counts neither way.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/core/voxel.h"
#include "sight_counts.h"

namespace dynemo {

/// First all points whose place is in question, then all scans in order of time, then questions.
class SeenThrough {
 public:
  explicit SeenThrough(const StructureParams& params);

  void addPoint(const Vector3& p_map);
  /// To be called once after the last point.
  void prepare();
  void look(const BeamGrid& scan, const Pose3& T_map_lidar);
  Permanence at(const Vector3& p_map) const;

 private:
  struct Place {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();      ///< of points less the voxel's corner
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();  ///< and of their outer products
    float points = 0.0f;
    Eigen::Vector3f middle;
    /// Of the surface around it; zero when the points are not on one.
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    SightCounts sights;
  };
  void findSurface(const Eigen::Vector3i& voxel, Place& place) const;
  const Place* find(const Eigen::Vector3i& voxel) const;

  StructureParams params_;
  SightParams sight_;
  std::unordered_map<Eigen::Vector3i, std::uint32_t, VoxelHash> index_;
  std::vector<Eigen::Vector3i> voxels_;
  std::vector<Place> places_;
  /// Places by blocks of the map, so that a scan looks only at those around it.
  std::map<std::array<int, 3>, std::vector<std::uint32_t>> blocks_;
};

}  // namespace dynemo
