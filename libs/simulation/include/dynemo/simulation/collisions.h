// Whether robot and entities have free way.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynemo/simulation/solids.h"
#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

/// An upright obstacle as seen from above.
struct Footprint {
  Pose3 T_world_box;
  Vector3 half = Vector3::Zero();
  std::string name;

  /// Distance from a point on the floor to the obstacle, 0 inside of it [m].
  double distance(const Vector2& p) const;
  double bottom_m() const { return T_world_box.t.z() - half.z(); }
  double top_m() const { return T_world_box.t.z() + half.z(); }
};

/// Walls and furniture of the world, not floors and ramps.
std::vector<Footprint> obstacles(const World& world);

/// Name of the nearest obstacle within the distance of a point, between two heights; empty when
/// there is none.
std::optional<std::string> obstacleWithin(const std::vector<Footprint>& obstacles, const Vector2& p,
                                          double distance_m, double bottom_m, double top_m);

/// Whether a wall or piece of furniture at a height stands between two points.
bool isBlocked(const std::vector<Footprint>& obstacles, const Vector3& from, const Vector3& to);

/// Throws ConfigError that says who meets what, where and when: the robot a wall, furniture, an
/// object or an agent; an agent or a sliding object a wall or furniture.
void requireFreeWay(const World& world);

}  // namespace dynemo::simulation
