// Places where something was seen in some scans and through which others look: what stood there
// only passed by, or is gone.
//
// As the range-image and free-space tests of map cleaning (G. Kim, A. Kim, "Remove, then revert",
// IROS 2020; A. Hornung et al., "OctoMap", Autonomous Robots 2013), but with single rays instead of
// voxels or pixels, so that what a sparse scan has between its rings counts neither way.
#pragma once

#include <vector>

#include "dynemo/core/se3.h"
#include "place_sights.h"
#include "voxel_index.h"

namespace dynemo {

/// First all points whose place is in question, then the looks of scans, then questions.
class SeenThrough {
 public:
  explicit SeenThrough(const StructureParams& params);

  void addPoint(const Vector3& p_map);
  /// To be called once after the last point: scans shall look at the places.
  void prepare(std::vector<Viewpoint> scans);
  PlaceSights& sights() { return sights_; }
  Permanence at(const Vector3& p_map) const;

 private:
  /// Of the points in one voxel, less its corner.
  struct Spread {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();  ///< sum of outer products
    float points = 0.0f;
  };
  Eigen::Vector3f normalAt(const Eigen::Vector3i& voxel) const;

  StructureParams params_;
  VoxelIndex index_;
  std::vector<Eigen::Vector3i> voxels_;
  std::vector<Spread> spreads_;  ///< until they are prepared
  PlaceSights sights_;
};

}  // namespace dynemo
