#include "dynemo/simulation/datasets.h"

#include <algorithm>
#include <cmath>

#include "dynemo/core/error.h"
#include "dynemo/simulation/robot_motion.h"
#include "floor_plans.h"
#include "placement.h"

namespace dynemo::simulation {
namespace {

enum class Place : std::uint8_t { kFurnishedRooms, kLargeRooms, kOneRoom, kHall, kTwoStoreys };
enum class Change : std::uint8_t { kNone, kRotated, kMoved };

/// What there is in one scale of a dataset.
struct Contents {
  int agents, objects, changed;
  double length_s;
  int min_laps;
};

struct Dataset {
  const char* name;
  const char* file_name;
  Place place;
  Change change;
  Contents full, mini;
};

const std::array<Dataset, 11>& table() {
  using enum Place;
  using enum Change;
  static const std::array<Dataset, 11> datasets{{
      {"S-SASO", "s_saso", kFurnishedRooms, kNone, {0, 11, 0, 373, 2}, {0, 5, 0, 90, 2}},
      {"S-SAMO", "s_samo", kFurnishedRooms, kMoved, {0, 11, 7, 644, 2}, {0, 5, 3, 90, 2}},
      {"S-MASO", "s_maso", kLargeRooms, kNone, {129, 15, 0, 351, 2}, {14, 5, 0, 90, 2}},
      {"S-MAMO", "s_mamo", kLargeRooms, kMoved, {129, 15, 9, 324, 2}, {14, 5, 3, 90, 2}},
      {"S-MASO2", "s_maso2", kOneRoom, kNone, {51, 6, 0, 111, 1}, {12, 4, 0, 40, 1}},
      {"S-MASO3", "s_maso3", kOneRoom, kNone, {51, 6, 0, 292, 3}, {12, 4, 0, 100, 3}},
      {"R-SARO", "r_saro", kHall, kRotated, {0, 8, 5, 111, 2}, {0, 6, 3, 60, 2}},
      {"R-SAMO", "r_samo", kHall, kMoved, {0, 8, 5, 173, 2}, {0, 6, 3, 60, 2}},
      {"R-MASO", "r_maso", kHall, kNone, {3, 8, 0, 93, 1}, {3, 6, 0, 60, 2}},
      {"R-MAMO", "r_mamo", kHall, kMoved, {3, 8, 5, 324, 2}, {3, 6, 3, 60, 2}},
      {"two-storeys", "two_storeys", kTwoStoreys, kMoved, {2, 8, 3, 300, 2}, {1, 6, 2, 110, 1}},
  }};
  return datasets;
}

FloorPlan planOf(const Dataset& dataset, Scale scale, Random& random) {
  switch (dataset.place) {
    case Place::kFurnishedRooms:
      return furnishedRooms(scale, random);
    case Place::kLargeRooms:
      return largeRooms(scale);
    case Place::kOneRoom:
      return oneRoom(scale);
    case Place::kHall:
      return hall(random);
    case Place::kTwoStoreys:
      return twoStoreys(random);
  }
  throw std::logic_error("unknown place");
}

bool isHandHeld(const Dataset& dataset) {
  return dataset.place == Place::kHall || dataset.place == Place::kTwoStoreys;
}

SensorSpecs sensorsOf(const Dataset& dataset, const DatasetOptions& options) {
  SensorSpecs s;
  const bool mini = options.scale == Scale::kMini;
  if (isHandHeld(dataset)) {
    s.lidar.rings = 64;
    s.lidar.pose = {0.01, 0.0, 0.08, -2.0, 0.6, -0.4};
    s.camera.pose = {0.05, 0.02, -0.04, 0.7, 6.0, -0.3};
    s.camera.distortion = {0.08, -0.18, 0.0006, -0.0004, 0.05};
    s.camera.delay_s = 0.013;
    s.odom3d.xy_per_sqrt_m = 0.012;
  }
  s.lidar.motion_distortion = options.motion_distortion.value_or(isHandHeld(dataset));
  if (mini) {
    s.lidar.rings = 32;
    s.lidar.columns = 512;
    s.lidar.rate_hz = s.camera.rate_hz = 5.0;
    s.lidar.quantum_m = 1.0 / 512.0;
    s.camera.width = 640;
    s.camera.height = 480;
    s.camera.fx = 460.0;
    s.camera.fy = 459.2;
    s.camera.cx = 323.4;
    s.camera.cy = 236.7;
    s.odom3d.rate_hz = s.odom2d.rate_hz = 10.0;
  }
  return s;
}

/// As many laps as come nearest to the nominal speed, and the speed that fills the time.
void fillTime(double length_s, int min_laps, World& world) {
  const double nominal_m_s = world.robot.speed_m_s;
  double best = 1e9;
  Robot chosen = world.robot;
  for (int laps = min_laps; laps < min_laps + 40; ++laps) {
    Robot robot = world.robot;
    robot.laps = laps;
    const RobotMotion motion(robot, world.seed);
    const double way_m = motion.distance(1e9), standing_s = motion.end_s() - way_m / nominal_m_s;
    constexpr double kSlowest = 0.3, kFastest = 1.2;
    const double moving_s = std::max(length_s - standing_s, 1.0);
    robot.speed_m_s = std::clamp(std::round(1e4 * way_m / moving_s) / 1e4, kSlowest, kFastest);
    const double off = std::abs(std::log(way_m / moving_s / nominal_m_s));
    if (off >= best) break;
    best = off;
    chosen = robot;
  }
  world.robot = chosen;
}

Robot robotOf(const Dataset& dataset, Scale scale, const FloorPlan& plan) {
  Robot robot;
  robot.route = plan.lap;
  robot.radius_m = plan.robot_radius_m;
  robot.speed_m_s = scale == Scale::kMini ? 0.95 : 0.65;
  robot.turn_rate_rad_s = scale == Scale::kMini ? 1.5 : 1.1;
  if (isHandHeld(dataset)) {
    robot.carrier = Carrier::kHand;
    robot.base_height_m = 1.25;
    robot.height_m = 1.7;
    robot.turn_rate_rad_s = 1.4;
  }
  return robot;
}

void addEntities(const Dataset& dataset, const Contents& contents, Random& random, World& world) {
  constexpr int kFirstAgent = 101;
  const bool hall = dataset.place == Place::kHall;
  Placement placement(world, random);
  placement.addObjects(hall ? "chair" : "box", contents.objects, 1);
  const double lap_s = RobotMotion(world.robot, world.seed).lap_s();
  const double explored_s = world.robot.laps > 1 ? lap_s : 0.4 * world.duration_s;
  if (dataset.change != Change::kNone)
    placement.relocateObjects(contents.changed, explored_s,
                              explored_s + 0.4 * (world.duration_s - explored_s),
                              dataset.change == Change::kRotated, hall);
  const int legged = hall && contents.agents > 2 ? 1 : 0;
  placement.addAgents("human", contents.agents - legged, kFirstAgent);
  if (legged > 0) placement.addAgents("quadruped", legged, kFirstAgent + contents.agents - legged);
}

}  // namespace

std::vector<std::string> datasetNames() {
  std::vector<std::string> names;
  for (const Dataset& dataset : table()) names.emplace_back(dataset.name);
  return names;
}

World makeDataset(const std::string& name, const DatasetOptions& options) {
  const auto it = std::find_if(table().begin(), table().end(),
                               [&](const Dataset& d) { return name == d.name; });
  if (it == table().end()) {
    std::string known;
    for (const std::string& other : datasetNames()) known += (known.empty() ? "" : ", ") + other;
    throw ConfigError("unknown dataset '" + name + "'; known: " + known);
  }
  const Contents& contents = options.scale == Scale::kMini ? it->mini : it->full;
  Random random(options.seed, Purpose::kPlan);
  const FloorPlan plan = planOf(*it, options.scale, random);
  World world;
  world.name = it->file_name;
  world.seed = options.seed;
  world.storeys = plan.storeys;
  world.robot = robotOf(*it, options.scale, plan);
  world.sensors = sensorsOf(*it, options);
  world.duration_s = std::max(contents.length_s, options.duration_s.value_or(0.0));
  fillTime(world.duration_s, contents.min_laps, world);
  addEntities(*it, contents, random, world);
  world.duration_s = options.duration_s.value_or(world.duration_s);
  return world;
}

}  // namespace dynemo::simulation
