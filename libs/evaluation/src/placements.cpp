#include "dynemo/evaluation/placements.h"

#include "dynemo/evaluation/entity_error.h"

namespace dynemo {

std::vector<Placement> findPlacements(const Trajectory& truth, const PlacementParams& params) {
  std::vector<Placement> placements;
  const auto keepIfLong = [&](const Placement& p) {
    if (secondsBetween(p.begin, p.end) >= params.min_duration_s) placements.push_back(p);
  };
  std::optional<Placement> current;
  for (const StampedPose& pose : truth) {
    if (current) {
      const PoseError motion = poseError(current->T_world_entity, pose.T);
      if (motion.translation_m <= params.max_translation_m &&
          motion.rotation_rad <= params.max_rotation_rad) {
        current->end = pose.stamp;
        continue;
      }
      keepIfLong(*current);
    }
    current = Placement{pose.stamp, pose.stamp, pose.T};
  }
  if (current) keepIfLong(*current);
  return placements;
}

std::optional<std::size_t> placementAt(const std::vector<Placement>& placements, Stamp stamp) {
  for (std::size_t i = 0; i < placements.size(); ++i) {
    if (placements[i].contains(stamp)) return i;
  }
  return std::nullopt;
}

}  // namespace dynemo
