// On which storey a keyframe is.
#pragma once

#include <optional>

#include "dynemo/core/fields.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

struct FloorParams {
  /// A keyframe is on a floor when the ground under it is at most this far from the floor's level.
  double level_tolerance_m = 0.5;
  /// Ground this far from every known level begins a new floor: more than a landing, less than a
  /// storey.
  double min_storey_m = 1.8;
  /// From one keyframe to the next the robot neither climbs nor descends more than this on a floor.
  double max_climb_m = 0.15;
  /// Steeper ground is a ramp.
  double max_slope_rad = 0.06;
  /// How far from level the ground may be where it counts as the floor: what it says of the robot's
  /// roll and pitch.
  double slope_sigma_rad = 0.005;
  /// Unevenness of the ground.
  double unevenness_sigma_m = 0.005;
};
void fields(FieldVisitor& v, FloorParams& p);

/// Ground that bears the robot, seen as a plane or known from what stands on it.
struct GroundLevel {
  double z_map_m = 0.0;
  double slope_rad = 0.0;
};

struct FloorChoice {
  /// The known floor; empty when there is none of that level.
  const CNodeFloor* floor = nullptr;
  /// Level of a floor that begins here.
  std::optional<double> new_level_m;
};

/// Height of the base over the ground it stands on, as it was when the first floor was found; empty
/// before that.
std::optional<double> baseHeight(const CSceneGraph& graph);

/// The floor of a keyframe at T_map_base. Known floors by height, so that a storey is found again
/// also after some drift; on stairs and ramps, between two levels, there is none.
FloorChoice chooseFloor(const CSceneGraph& graph, const Pose3& T_map_base,
                        const std::optional<GroundLevel>& ground, const FloorParams& params);

}  // namespace dynemo
