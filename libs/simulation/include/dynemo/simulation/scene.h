// A world in motion: every sensor looks at it at its own times.
#pragma once

#include <vector>

#include "dynemo/simulation/entity_motion.h"
#include "dynemo/simulation/ray_caster.h"
#include "dynemo/simulation/robot_motion.h"
#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

/// Immutable; shared by all threads.
class Scene {
 public:
  explicit Scene(const World& world)
      : world_(world),
        motion_(world.robot, world.seed),
        bodies_(makeBodies(world)),
        caster_(bodies_) {
    for (const Entity& entity : world.entities) entities_.emplace_back(entity, world.relocations);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const World& world() const { return world_; }
  const RobotMotion& robot() const { return motion_; }
  const std::vector<EntityMotion>& entities() const { return entities_; }
  /// The static world, then the entities in the order of the world.
  const std::vector<Body>& bodies() const { return bodies_; }
  const RayCaster& caster() const { return caster_; }

  /// T_world_entity of all entities.
  std::vector<Pose3> entityPoses(double t_s) const {
    std::vector<Pose3> poses;
    poses.reserve(entities_.size());
    for (const EntityMotion& entity : entities_) poses.push_back(entity.at(t_s));
    return poses;
  }

 private:
  static std::vector<Body> makeBodies(const World& world) {
    std::vector<Body> bodies{staticBody(world)};
    for (const Entity& entity : world.entities) bodies.push_back(entityBody(entity));
    return bodies;
  }

  World world_;
  RobotMotion motion_;
  std::vector<EntityMotion> entities_;
  std::vector<Body> bodies_;
  RayCaster caster_;
};

}  // namespace dynemo::simulation
