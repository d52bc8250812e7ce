#include "dynemo/mapping/floors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dynemo {

void fields(FieldVisitor& v, FloorParams& p) {
  v.number("level_tolerance_m", p.level_tolerance_m,
           "Distance from a floor's level at which a keyframe is on it", Range::positive());
  v.number("min_storey_m", p.min_storey_m, "Least height between two floors", Range::positive());
  v.number("max_climb_m", p.max_climb_m,
           "A keyframe that climbed more since the last one begins no floor", Range::positive());
  v.angle("max_slope_deg", p.max_slope_rad, "Steeper ground is a ramp", {0.0, 90.0, true});
  v.angle("slope_sigma_deg", p.slope_sigma_rad,
          "How far from level a floor is; large values leave roll and pitch to other sensors",
          Range::positive());
  v.number("unevenness_sigma_m", p.unevenness_sigma_m, "How far from flat a floor is",
           Range::positive());
}

std::optional<double> baseHeight(const CSceneGraph& graph) {
  for (const auto& keyframe : graph.keyframes()) {
    const auto* floor = keyframe->floor ? graph.findNode<CNodeFloor>(*keyframe->floor) : nullptr;
    if (floor) return keyframe->T_map_base().t.z() - floor->level_m;
  }
  return std::nullopt;
}

FloorChoice chooseFloor(const CSceneGraph& graph, const Pose3& T_map_base,
                        const std::optional<GroundLevel>& ground, const FloorParams& params) {
  const bool level = ground && ground->slope_rad <= params.max_slope_rad;
  const auto base_height_m = baseHeight(graph);
  if (!base_height_m) return {nullptr, level ? std::optional(ground->z_map_m) : std::nullopt};

  const double z_map_m = level ? ground->z_map_m : T_map_base.t.z() - *base_height_m;
  const CNodeFloor* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& floor : graph.floors()) {
    const double distance_m = std::abs(floor->level_m - z_map_m);
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = floor.get();
  }
  if (nearest && nearest_m <= params.level_tolerance_m) return {nearest, std::nullopt};
  const double climbed_m = T_map_base.t.z() - graph.keyframes().back()->T_map_base().t.z();
  const bool begins =
      level && nearest_m >= params.min_storey_m && std::abs(climbed_m) <= params.max_climb_m;
  return {nullptr, begins ? std::optional(z_map_m) : std::nullopt};
}

}  // namespace dynemo
