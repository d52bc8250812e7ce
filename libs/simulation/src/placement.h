// Puts entities where they are in nobody's way.
#pragma once

#include "dynemo/simulation/collisions.h"
#include "dynemo/simulation/robot_motion.h"
#include "dynemo/simulation/world.h"
#include "random.h"

namespace dynemo::simulation {

/// Draws places for the entities of a world whose storeys, robot and duration are set.
class Placement {
 public:
  Placement(World& world, Random& random);

  /// Boxes and chairs next to the route. Throws ConfigError when there is no space.
  void addObjects(const std::string& model, int count, int first_id);
  /// People to and fro in a straight line who never meet the robot.
  void addAgents(const std::string& model, int count, int first_id);
  /// The first `count` objects are moved, one after the other, between two times while the camera
  /// looks away; `in_view`: every second one slides or turns in plain sight. `rotate`: they only
  /// turn.
  void relocateObjects(int count, double from_s, double to_s, bool rotate, bool in_view);

 private:
  struct Disc {
    Vector2 at;
    double radius_m;
    double floor_z_m;
  };

  const Storey& randomStorey();
  bool isFree(const Disc& disc, double route_clearance_m) const;
  Disc freePlace(double radius_m);
  bool meetsRobot(const AgentPath& path, double floor_z_m) const;
  bool isSeen(const Vector3& p, double t_s) const;
  bool slidesFreely(const Vector2& from, const Vector2& to, double radius_m, double time_s,
                    double duration_s) const;
  void drawTags(Entity& entity, std::size_t count);

  World& world_;
  Random& random_;
  RobotMotion robot_;
  std::vector<Footprint> solids_;
  std::vector<Vector3> robot_at_;  ///< every kStep_s
  std::vector<Disc> taken_;
  std::vector<int> free_tags_;
};

}  // namespace dynemo::simulation
