#pragma once

#include "dynemo/core/fields.h"

namespace dynemo {

/// What a map's scans show of structure, and what belongs to entities or was only passing.
struct StructureParams {
  /// Entities fill the box (objects) or the upright cylinder (agents) of all that was ever seen of
  /// them, and so much around it.
  bool volumes = true;
  double margin_m = 0.05;
  /// Between two observations of an agent that are at most so far apart in time it was on the
  /// straight line between them.
  double agent_gap_s = 2.0;
  /// Points so near to a mapped floor, wall or ceiling are structure, whatever stands there.
  double surface_tolerance_m = 0.05;

  /// What other scans see through is no structure.
  bool seen_through = true;
  /// Size of the places that are judged as one.
  double voxel_m = 0.1;
  /// Scans from further away say nothing of a place.
  double max_range_m = 15.0;
  /// So many scans at most look at a place, from viewpoints and at times that lie apart; four times
  /// as many where these do not tell.
  int max_looks = 64;
  /// A ray goes through a place when it passes its middle this closely and ends so far behind it.
  double ray_radius_m = 0.05;
  double behind_m = 0.15;
  /// A place is no structure when at least `min_through` scans see through it and less than this
  /// share of the scans that look there see something.
  int min_through = 2;
  double max_hit_share = 0.4;
  /// It is none either when the scans since something was last seen there would be as unlikely as
  /// this, were it still there.
  double gone_probability = 0.001;

  bool operator==(const StructureParams&) const = default;
};
void fields(FieldVisitor& v, StructureParams& p);

}  // namespace dynemo
