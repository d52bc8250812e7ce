#include "dynemo/simulation/collisions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "dynemo/core/error.h"
#include "dynemo/simulation/entity_motion.h"
#include "dynemo/simulation/robot_motion.h"

namespace dynemo::simulation {
namespace {

constexpr double kStep_s = 0.1;
/// Where the robot must not be from people's middles, beyond its own radius.
constexpr double kAgentRadius_m = 0.3;
constexpr double kFloorClearance_m = 0.05;

std::string placeText(double t_s, const Vector2& p) {
  char text[96];
  std::snprintf(text, sizeof(text), " at %.1f s, x = %.2f, y = %.2f", t_s, p.x(), p.y());
  return text;
}

double entityRadius(const Entity& entity) {
  if (entity.isAgent()) return kAgentRadius_m;
  const auto [low, high] = bounds(entityBody(entity));
  return std::max(low.head<2>().cwiseAbs().maxCoeff(), high.head<2>().cwiseAbs().maxCoeff());
}

void checkRobot(const World& world, const std::vector<Footprint>& solids, const RobotMotion& robot,
                const std::vector<EntityMotion>& entities) {
  const double end_s = std::min(world.duration_s, robot.end_s());
  for (double t_s = 0.0; t_s <= end_s; t_s += kStep_s) {
    const Vector3 p = robot.floorPoint(t_s);
    const auto met = obstacleWithin(solids, p.head<2>(), world.robot.radius_m,
                                    p.z() + kFloorClearance_m, p.z() + world.robot.height_m);
    if (met) throw ConfigError(world.name + ": robot: meets " + *met + placeText(t_s, p.head<2>()));
    for (std::size_t i = 0; i < entities.size(); ++i) {
      const Vector3 q = entities[i].at(t_s).t;
      if (std::abs(q.z() - p.z()) > 1.5) continue;
      if ((q - p).head<2>().norm() < world.robot.radius_m + entityRadius(world.entities[i]))
        throw ConfigError(world.name + ": robot: meets entity " +
                          std::to_string(world.entities[i].id) + placeText(t_s, p.head<2>()));
    }
  }
}

void checkEntity(const World& world, const std::vector<Footprint>& solids, const Entity& entity,
                 const EntityMotion& motion) {
  const double radius_m = 0.8 * entityRadius(entity);
  for (double t_s = 0.0; t_s <= world.duration_s; t_s += kStep_s) {
    const Vector2 p = motion.at(t_s).t.head<2>();
    const auto met = obstacleWithin(solids, p, radius_m, entity.floor_z_m + kFloorClearance_m,
                                    entity.floor_z_m + 1.7);
    if (met)
      throw ConfigError(world.name + ": entity " + std::to_string(entity.id) + ": meets " + *met +
                        placeText(t_s, p));
  }
}

}  // namespace

double Footprint::distance(const Vector2& p) const {
  const Vector3 local = T_world_box.inverse() * Vector3(p.x(), p.y(), T_world_box.t.z());
  const Vector2 beyond = (local.head<2>().cwiseAbs() - half.head<2>()).cwiseMax(0.0);
  return beyond.norm();
}

std::vector<Footprint> obstacles(const World& world) {
  std::vector<Footprint> list;
  for (const Box& box : staticBody(world).boxes) {
    if (!box.walkable) list.push_back({box.T_body_box, box.half, box.name});
  }
  return list;
}

std::optional<std::string> obstacleWithin(const std::vector<Footprint>& obstacles, const Vector2& p,
                                          double distance_m, double bottom_m, double top_m) {
  std::optional<std::string> nearest;
  for (const Footprint& o : obstacles) {
    if (o.top_m() <= bottom_m || o.bottom_m() >= top_m) continue;
    const double d_m = o.distance(p);
    if (d_m >= distance_m) continue;
    distance_m = d_m;
    nearest = o.name;
  }
  return nearest;
}

bool isBlocked(const std::vector<Footprint>& obstacles, const Vector3& from, const Vector3& to) {
  return std::any_of(obstacles.begin(), obstacles.end(), [&](const Footprint& o) {
    // The segment against the box's slabs.
    const Vector3 a = o.T_world_box.inverse() * from, b = o.T_world_box.inverse() * to;
    double enter = 0.0, leave = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double way = b[axis] - a[axis];
      if (std::abs(way) < 1e-12) {
        if (std::abs(a[axis]) > o.half[axis]) return false;
        continue;
      }
      const double s0 = (-o.half[axis] - a[axis]) / way, s1 = (o.half[axis] - a[axis]) / way;
      enter = std::max(enter, std::min(s0, s1));
      leave = std::min(leave, std::max(s0, s1));
    }
    return enter < leave;
  });
}

void requireFreeWay(const World& world) {
  const std::vector<Footprint> solids = obstacles(world);
  const RobotMotion robot(world.robot, world.seed);
  std::vector<EntityMotion> entities;
  for (const Entity& entity : world.entities) entities.emplace_back(entity, world.relocations);
  checkRobot(world, solids, robot, entities);
  for (std::size_t i = 0; i < entities.size(); ++i)
    checkEntity(world, solids, world.entities[i], entities[i]);
}

}  // namespace dynemo::simulation
