#pragma once

#include <optional>
#include <vector>

#include "dynemo/evaluation/entity_data.h"

namespace dynemo {

/// An interval in which an object stays where it is.
struct Placement {
  Stamp begin, end;
  Pose3 T_world_entity;
  bool contains(Stamp stamp) const { return begin <= stamp && stamp <= end; }
};

struct PlacementParams {
  /// Distance from where it came to rest up to which the object counts as resting.
  double max_translation_m = 1e-3;
  double max_rotation_rad = 1e-3;
  /// Shorter rests belong to the motion around them.
  double min_duration_s = 0.5;
};

/// The placements of one object in the order of time.
std::vector<Placement> findPlacements(const Trajectory& truth, const PlacementParams& params = {});

/// Index of the placement that contains the stamp.
std::optional<std::size_t> placementAt(const std::vector<Placement>& placements, Stamp stamp);

}  // namespace dynemo
