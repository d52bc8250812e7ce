// A place to drive through: what a world file holds (share/doc/simulation.md).
//
// World frame: z up. Positions on a floor are x y [m]; yaws are radians here and degrees in the
// file. Times are seconds after the start of the recording.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/simulation/sensor_specs.h"

namespace dynemo::simulation {

/// Axis-parallel rectangle in the floor's plane.
struct Rect {
  double x_min = 0, y_min = 0, x_max = 0, y_max = 0;

  double area() const { return (x_max - x_min) * (y_max - y_min); }
  bool contains(const Vector2& p, double margin_m = 0.0) const;
};

/// A doorway, by the distance of its middle from the beginning of the wall.
struct Door {
  double at_m = 0.0;
  double width_m = 1.0;
  double height_m = 2.1;
};

/// From floor to ceiling, on both sides of the line between two points.
struct Wall {
  Vector2 from = Vector2::Zero(), to = Vector2::Zero();
  double thickness_m = 0.12;
  std::vector<Door> doors;
};

struct Furniture {
  std::string model;  ///< one of furnitureModels()
  Vector2 at = Vector2::Zero();
  double yaw_rad = 0.0;
  Vector3 size = Vector3::Ones();  ///< along its own x, y, and height
};

/// A slope or flight of steps on which the robot can go, from one height to another.
struct Ramp {
  Vector3 from = Vector3::Zero(), to = Vector3::Zero();
  double width_m = 1.2;
  int steps = 0;  ///< 0: a smooth slope
};

struct Storey {
  std::string name;
  Rect outline;
  double floor_z_m = 0.0;
  double ceiling_z_m = 2.7;
  std::vector<Rect> floor_openings, ceiling_openings;
  std::vector<Wall> walls;
  std::vector<Furniture> furniture;
  std::vector<Ramp> ramps;
};

/// To and fro between two points, turning at both ends.
struct AgentPath {
  Vector2 from = Vector2::Zero(), to = Vector2::Zero();
  double speed_m_s = 0.8;
  double turn_s = 1.2;
  double phase_s = 0.0;  ///< time since the last departure from `from`, at the start
};

/// A tagged object, or a tagged agent when it has a path.
struct Entity {
  int id = 0;
  std::string model;  ///< one of entityModels()
  Vector2 at = Vector2::Zero();
  double yaw_rad = 0.0;
  double floor_z_m = 0.0;
  std::optional<Vector3> size;  ///< of models that come in any size
  std::vector<int> tag_ids;     ///< in the order of the model's tags
  std::optional<AgentPath> path;

  bool isAgent() const { return path.has_value(); }
};

/// An object is somewhere else from then on; with a duration it slides there in a straight line.
struct Relocation {
  int entity = 0;
  double time_s = 0.0;
  double duration_s = 0.0;
  Vector2 to = Vector2::Zero();
  double yaw_rad = 0.0;
};

enum class Carrier : std::uint8_t { kWheels, kHand };

struct RoutePoint {
  Vector3 at = Vector3::Zero();  ///< on the floor
  double wait_s = 0.0;
};

/// The robot drives from point to point; hand-held sensors sway, look about and step.
struct Robot {
  Carrier carrier = Carrier::kWheels;
  std::vector<RoutePoint> route;
  int laps = 1;  ///< how often the route is gone; a lap begins where the one before ended
  double speed_m_s = 0.7;
  double turn_rate_rad_s = 1.0;
  double base_height_m = 0.12;
  double radius_m = 0.25;
  double height_m = 0.9;
};

struct World {
  std::string name = "world";
  int seed = 0;
  double duration_s = 60.0;
  std::vector<Storey> storeys;
  std::vector<Entity> entities;
  std::vector<Relocation> relocations;  ///< by time
  Robot robot;
  SensorSpecs sensors;

  const Entity* findEntity(int id) const;
};

}  // namespace dynemo::simulation
