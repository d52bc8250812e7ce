// The beginning of a map of moving sweeps.
#pragma once

#include <vector>

#include "dynemo/odometry/registration.h"
#include "dynemo/odometry/voxel_hash_map.h"

namespace dynemo {

/// A sweep in the map.
struct MappedSweep {
  SurfacePoints surface;
  Stamp stamp;
  /// Reference time after the stamp, the middle of the sweep.
  double middle_s = 0.0;
  Pose3 T_odom_middle;
  SweepMotion motion;
};

/// Adds the points, carried to the middle of the sweep, to the map.
void insertSweep(const MappedSweep& sweep, VoxelHashMap& map);

/// An error of the motion that is common to all sweeps stretches the map as much as it stretches
/// each sweep, so that registration cannot see it; it shows where the motion during the sweeps
/// disagrees with the displacements between them. This keeps the first sweeps and, from time to
/// time, corrects their common error and builds the map again.
class FirstSweeps {
 public:
  FirstSweeps(const RegistrationParams& params, const RegistrationPrior& prior, WorkerPool& pool)
      : params_(params), prior_(prior), pool_(pool) {}

  /// Adds a sweep that is in the map already. True when the map was built again; the last sweep's
  /// pose and motion have then changed too, while the base at the first stamp stays where it was.
  bool add(MappedSweep sweep, VoxelHashMap& map);
  const MappedSweep& last() const { return sweeps_.back(); }
  /// True once the beginning is over.
  bool complete() const;

 private:
  using Sweeps = std::vector<MappedSweep>;

  bool refine(Sweeps& sweeps, VoxelHashMap& map) const;
  bool registerTo(const VoxelHashMap& map, MappedSweep& sweep) const;

  RegistrationParams params_;
  RegistrationPrior prior_;
  WorkerPool& pool_;
  Sweeps sweeps_;
  Pose3 T_odom_origin_;
};

}  // namespace dynemo
