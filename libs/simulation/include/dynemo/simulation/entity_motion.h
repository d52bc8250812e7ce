// Where an entity truly is at any time.
#pragma once

#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

class EntityMotion {
 public:
  EntityMotion(const Entity& entity, const std::vector<Relocation>& relocations);

  /// T_world_entity.
  Pose3 at(double t_s) const;

  /// The object's placements: where it is from when on, and how long it took to get there.
  struct Placement {
    double time_s = 0.0, duration_s = 0.0;
    Vector2 at = Vector2::Zero();
    double yaw_rad = 0.0;
  };
  const std::vector<Placement>& placements() const { return placements_; }
  bool isAgent() const { return path_.has_value(); }

 private:
  Pose3 agentAt(double t_s) const;
  Pose3 objectAt(double t_s) const;

  std::optional<AgentPath> path_;
  std::vector<Placement> placements_;
  double z_m_ = 0.0;
};

}  // namespace dynemo::simulation
