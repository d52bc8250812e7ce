#include "dynemo/simulation/world_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/core/yaml_place.h"
#include "dynemo/simulation/solids.h"
#include "tag_pattern.h"

namespace dynemo::simulation {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLargestPlace_m = 500.0, kLongest_s = 24 * 3600.0;

using Place = YamlPlace;

// ---- reading ----

double number(const Place& place, Range range) {
  const double value = place.number();
  if (!range.contains(value)) place.fail("must be " + range.text());
  return value;
}

/// Overwrites the value when the key is there.
void optional(const Place& place, const char* key, double& value, Range range = {}) {
  if (place.has(key)) value = number(place.at(key), range);
}
void optionalAngle(const Place& place, const char* key_deg, double& value_rad) {
  if (place.has(key_deg))
    value_rad = kDegree * number(place.at(key_deg), Range::between(-3600, 3600));
}
void optional(const Place& place, const char* key, int& value, Range range) {
  if (!place.has(key)) return;
  value = place.at(key).as<int>("an integer");
  if (!range.contains(value)) place.at(key).fail("must be " + range.text());
}

template <int N>
Eigen::Matrix<double, N, 1> position(const Place& place) {
  const auto p = place.vector<N>();
  if (p.cwiseAbs().maxCoeff() > kLargestPlace_m)
    place.fail("must be within " + exactNumber(kLargestPlace_m) + " m of the origin");
  return p;
}

template <class Parse>
void each(const Place& place, const char* key, const std::string& name, Parse parse) {
  if (!place.has(key)) return;
  const Place list = place.at(key);
  list.expectSequence();
  for (std::size_t i = 0; i < list.size(); ++i)
    parse(list.at(i).named(name + " " + std::to_string(i)));
}

Rect parseRect(const Place& place) {
  const auto v = place.vector<4>();
  if (v.cwiseAbs().maxCoeff() > kLargestPlace_m || v[0] >= v[2] || v[1] >= v[3])
    place.fail("must be x_min y_min x_max y_max, within 500 m of the origin");
  return {v[0], v[1], v[2], v[3]};
}

Wall parseWall(const Place& place, double height_m) {
  place.expectMap({"from", "to", "thickness", "doors"});
  Wall wall;
  wall.from = position<2>(place.at("from"));
  wall.to = position<2>(place.at("to"));
  const double length_m = (wall.to - wall.from).norm();
  if (length_m < 0.01) place.at("to").fail("must be away from 'from'");
  optional(place, "thickness", wall.thickness_m, Range::between(0.01, 5));
  each(place, "doors", "door", [&](const Place& door_place) {
    door_place.expectMap({"at", "width", "height"});
    Door door;
    door.at_m = number(door_place.at("at"), Range::between(0, length_m));
    optional(door_place, "width", door.width_m, Range::positive());
    optional(door_place, "height", door.height_m, Range::between(0.1, height_m));
    if (door.at_m - 0.5 * door.width_m < 0 || door.at_m + 0.5 * door.width_m > length_m)
      door_place.fail("reaches beyond the wall");
    for (const Door& other : wall.doors) {
      if (std::abs(other.at_m - door.at_m) < 0.5 * (other.width_m + door.width_m))
        door_place.fail("overlaps another door");
    }
    wall.doors.push_back(door);
  });
  return wall;
}

Furniture parseFurniture(const Place& place) {
  place.expectMap({"model", "at", "yaw_deg", "size"});
  Furniture item;
  item.model = place.at("model").word();
  const auto known = furnitureModels();
  if (std::find(known.begin(), known.end(), item.model) == known.end()) {
    std::string list;
    for (const auto& name : known) list += (list.empty() ? "" : ", ") + name;
    place.at("model").fail("is no furniture; known: " + list);
  }
  item.at = position<2>(place.at("at"));
  optionalAngle(place, "yaw_deg", item.yaw_rad);
  item.size = place.at("size").vector<3>();
  if (item.size.minCoeff() < 0.05 || item.size.maxCoeff() > 20)
    place.at("size").fail("must be in [0.05, 20]");
  return item;
}

Ramp parseRamp(const Place& place) {
  place.expectMap({"from", "to", "width", "steps"});
  Ramp ramp;
  ramp.from = position<3>(place.at("from"));
  ramp.to = position<3>(place.at("to"));
  if ((ramp.to - ramp.from).head<2>().norm() < 0.1) place.at("to").fail("must be away from 'from'");
  optional(place, "width", ramp.width_m, Range::positive());
  optional(place, "steps", ramp.steps, Range::between(0, 200));
  return ramp;
}

Storey parseStorey(const Place& unnamed) {
  unnamed.expectMap({"name", "outline", "floor_z", "ceiling_z", "floor_openings",
                     "ceiling_openings", "walls", "furniture", "ramps"});
  Storey storey;
  storey.name = unnamed.at("name").word();
  const Place place = unnamed.named(storey.name);
  storey.outline = parseRect(place.at("outline"));
  optional(place, "floor_z", storey.floor_z_m, Range::between(-kLargestPlace_m, kLargestPlace_m));
  storey.ceiling_z_m =
      number(place.at("ceiling_z"), Range::between(-kLargestPlace_m, kLargestPlace_m));
  if (storey.ceiling_z_m < storey.floor_z_m + 0.5)
    place.at("ceiling_z").fail("must be ≥ floor_z + 0.5");
  each(place, "floor_openings", "opening",
       [&](const Place& p) { storey.floor_openings.push_back(parseRect(p)); });
  each(place, "ceiling_openings", "opening",
       [&](const Place& p) { storey.ceiling_openings.push_back(parseRect(p)); });
  each(place, "walls", "wall", [&](const Place& p) {
    storey.walls.push_back(parseWall(p, storey.ceiling_z_m - storey.floor_z_m));
  });
  each(place, "furniture", "item",
       [&](const Place& p) { storey.furniture.push_back(parseFurniture(p)); });
  each(place, "ramps", "ramp", [&](const Place& p) { storey.ramps.push_back(parseRamp(p)); });
  return storey;
}

AgentPath parsePath(const Place& place) {
  place.expectMap({"from", "to", "speed", "turn_s", "phase_s"});
  AgentPath path;
  path.from = position<2>(place.at("from"));
  path.to = position<2>(place.at("to"));
  if ((path.to - path.from).norm() < 0.1) place.at("to").fail("must be away from 'from'");
  optional(place, "speed", path.speed_m_s, Range::between(0.01, 5));
  optional(place, "turn_s", path.turn_s, Range::between(0.1, 60));
  optional(place, "phase_s", path.phase_s, Range::nonNegative());
  return path;
}

Entity parseEntity(const Place& unnamed) {
  unnamed.expectMap({"id", "model", "at", "yaw_deg", "floor_z", "size", "tags", "path"});
  Entity entity;
  entity.id = unnamed.at("id").as<int>("an integer");
  const Place place = unnamed.named("entity " + std::to_string(entity.id));
  if (entity.id < 0) place.at("id").fail("must be ≥ 0");
  entity.model = place.at("model").word();
  const EntityModelInfo* model = findEntityModel(entity.model);
  if (model == nullptr) {
    std::string list;
    for (const auto& m : entityModels()) list += (list.empty() ? "" : ", ") + m.name;
    place.at("model").fail("is no model of an entity; known: " + list);
  }
  optional(place, "floor_z", entity.floor_z_m, Range::between(-kLargestPlace_m, kLargestPlace_m));
  if (model->agent) {
    entity.path = parsePath(place.at("path"));
  } else {
    if (place.has("path")) place.at("path").fail("is for agents only");
    entity.at = position<2>(place.at("at"));
    optionalAngle(place, "yaw_deg", entity.yaw_rad);
  }
  if (model->sized) {
    entity.size = place.at("size").vector<3>();
    if (entity.size->minCoeff() < 0.1 || entity.size->maxCoeff() > 5)
      place.at("size").fail("must be in [0.1, 5]");
  } else if (place.has("size")) {
    place.at("size").fail("is not for this model");
  }
  const Place tags = place.at("tags");
  tags.expectSequence(model->tags);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const int id = tags.at(i).as<int>("an integer");
    if (id < 0 || id >= kTagFamilySize) tags.at(i).fail("must be in [0, 586], the ids of tag36h11");
    entity.tag_ids.push_back(id);
  }
  return entity;
}

Relocation parseRelocation(const Place& place, const World& world) {
  place.expectMap({"entity", "time_s", "duration_s", "to", "yaw_deg"});
  Relocation relocation;
  relocation.entity = place.at("entity").as<int>("an integer");
  const Entity* entity = world.findEntity(relocation.entity);
  if (entity == nullptr) place.at("entity").fail("is not the id of an entity");
  if (entity->isAgent()) place.at("entity").fail("is an agent, which moves by itself");
  relocation.time_s = number(place.at("time_s"), Range::between(0.001, kLongest_s));
  optional(place, "duration_s", relocation.duration_s, Range::between(0, 600));
  relocation.to = position<2>(place.at("to"));
  optionalAngle(place, "yaw_deg", relocation.yaw_rad);
  return relocation;
}

RoutePoint parseRoutePoint(const Place& place) {
  place.expectMap({"at", "wait_s"});
  RoutePoint point;
  const Place at = place.at("at");
  at.expectSequence();
  if (at.size() == 3)
    point.at = position<3>(at);
  else
    point.at << position<2>(at), 0.0;
  optional(place, "wait_s", point.wait_s, Range::between(0, 3600));
  return point;
}

Robot parseRobot(const Place& place) {
  place.expectMap(
      {"carrier", "route", "laps", "speed", "turn_rate_deg_s", "base_height", "radius", "height"});
  Robot robot;
  const std::string carrier = place.has("carrier") ? place.at("carrier").word() : "wheels";
  if (carrier != "wheels" && carrier != "hand") place.at("carrier").fail("must be wheels or hand");
  robot.carrier = carrier == "wheels" ? Carrier::kWheels : Carrier::kHand;
  place.at("route").expectSequence();
  each(place, "route", "point", [&](const Place& p) { robot.route.push_back(parseRoutePoint(p)); });
  if (robot.route.empty()) place.at("route").fail("must have at least one point");
  optional(place, "laps", robot.laps, Range::between(1, 1000));
  optional(place, "speed", robot.speed_m_s, Range::between(0.01, 10));
  double turn_rate_deg_s = robot.turn_rate_rad_s / kDegree;
  optional(place, "turn_rate_deg_s", turn_rate_deg_s, Range::between(1, 720));
  robot.turn_rate_rad_s = kDegree * turn_rate_deg_s;
  optional(place, "base_height", robot.base_height_m, Range::between(0, 3));
  optional(place, "radius", robot.radius_m, Range::between(0.01, 3));
  optional(place, "height", robot.height_m, Range::between(0.1, 3));
  return robot;
}

SensorSpecs parseSensors(const Place& place) {
  SensorSpecs sensors;
  if (place.has("sensors")) {
    const Place section = place.at("sensors");
    if (!section.node().IsMap()) section.fail("must be a mapping");
    ConfigLoader loader;
    loader.addText(YAML::Dump(section.node()), section.where());
    load(loader, sensors);
    check(sensors, section.where());
  }
  return sensors;
}

void requireUnique(const Place& top, const World& world) {
  std::set<int> ids;
  std::map<int, int> tags;
  for (const Entity& entity : world.entities) {
    if (!ids.insert(entity.id).second)
      top.at("entities").fail("id " + std::to_string(entity.id) + " is given twice");
    for (const int tag : entity.tag_ids) {
      const auto [it, fresh] = tags.emplace(tag, entity.id);
      if (!fresh)
        top.at("entities")
            .fail("tag " + std::to_string(tag) + " is on entities " + std::to_string(it->second) +
                  " and " + std::to_string(entity.id));
    }
  }
}

World parseTop(const Place& top) {
  if (top.isNull()) top.fail("is empty");
  top.expectMap(
      {"name", "seed", "duration_s", "storeys", "entities", "relocations", "robot", "sensors"});
  World world;
  world.name = top.at("name").word();
  if (world.name.find_first_of("/\\ ") != std::string::npos)
    top.at("name").fail("must be a file name without blanks");
  optional(top, "seed", world.seed, Range::between(0, 10000));
  world.duration_s = number(top.at("duration_s"), Range::between(0.1, kLongest_s));
  each(top, "storeys", "storey", [&](const Place& p) { world.storeys.push_back(parseStorey(p)); });
  if (world.storeys.empty()) top.fail("lacks 'storeys'");
  each(top, "entities", "entity",
       [&](const Place& p) { world.entities.push_back(parseEntity(p)); });
  requireUnique(top, world);
  each(top, "relocations", "relocation",
       [&](const Place& p) { world.relocations.push_back(parseRelocation(p, world)); });
  std::stable_sort(world.relocations.begin(), world.relocations.end(),
                   [](const Relocation& a, const Relocation& b) { return a.time_s < b.time_s; });
  world.robot = parseRobot(top.at("robot"));
  world.sensors = parseSensors(top);
  return world;
}

// ---- writing ----

class Writer {
 public:
  explicit Writer(const World& world) : world_(world) {}

  std::string text() {
    out_ << "# A world of dynemo-simulate: metres, seconds, degrees; z up. See "
            "share/doc/simulation.md.\n";
    out_ << "name: " << world_.name << "\nseed: " << world_.seed
         << "\nduration_s: " << n(world_.duration_s) << "\n\nstoreys:\n";
    for (const Storey& storey : world_.storeys) write(storey);
    out_ << "\nentities:" << (world_.entities.empty() ? " []\n" : "\n");
    for (const Entity& entity : world_.entities) write(entity);
    out_ << "\nrelocations:" << (world_.relocations.empty() ? " []\n" : "\n");
    for (const Relocation& r : world_.relocations) {
      out_ << "  - {entity: " << r.entity << ", time_s: " << n(r.time_s);
      if (r.duration_s > 0) out_ << ", duration_s: " << n(r.duration_s);
      out_ << ", to: " << list(r.to) << ", yaw_deg: " << degrees(r.yaw_rad) << "}\n";
    }
    write(world_.robot);
    writeSensors();
    return out_.str();
  }

 private:
  static std::string n(double value) { return exactNumber(value); }
  /// To 1e-9 degrees, so that an angle read from a file is written as it stood there.
  static std::string degrees(double rad) {
    return exactNumber(std::round(rad / kDegree * 1e9) / 1e9);
  }
  template <class Vector>
  static std::string list(const Vector& v) {
    std::string text;
    for (int i = 0; i < v.size(); ++i) text += (i == 0 ? "[" : ", ") + n(v[i]);
    return text + "]";
  }
  static std::string list(const Rect& r) {
    return list(Eigen::Vector4d(r.x_min, r.y_min, r.x_max, r.y_max));
  }

  void write(const Storey& storey) {
    out_ << "  - name: " << storey.name << "\n    outline: " << list(storey.outline)
         << "\n    floor_z: " << n(storey.floor_z_m) << "\n    ceiling_z: " << n(storey.ceiling_z_m)
         << "\n";
    writeOpenings("floor_openings", storey.floor_openings);
    writeOpenings("ceiling_openings", storey.ceiling_openings);
    if (!storey.walls.empty()) out_ << "    walls:\n";
    for (const Wall& wall : storey.walls) {
      out_ << "      - {from: " << list(wall.from) << ", to: " << list(wall.to)
           << ", thickness: " << n(wall.thickness_m);
      if (!wall.doors.empty()) out_ << ", doors: [";
      for (std::size_t i = 0; i < wall.doors.size(); ++i) {
        const Door& door = wall.doors[i];
        out_ << (i == 0 ? "" : ", ") << "{at: " << n(door.at_m) << ", width: " << n(door.width_m)
             << ", height: " << n(door.height_m) << "}";
      }
      out_ << (wall.doors.empty() ? "}\n" : "]}\n");
    }
    if (!storey.furniture.empty()) out_ << "    furniture:\n";
    for (const Furniture& item : storey.furniture)
      out_ << "      - {model: " << item.model << ", at: " << list(item.at)
           << ", yaw_deg: " << degrees(item.yaw_rad) << ", size: " << list(item.size) << "}\n";
    if (!storey.ramps.empty()) out_ << "    ramps:\n";
    for (const Ramp& ramp : storey.ramps)
      out_ << "      - {from: " << list(ramp.from) << ", to: " << list(ramp.to)
           << ", width: " << n(ramp.width_m) << ", steps: " << ramp.steps << "}\n";
  }

  void writeOpenings(const char* key, const std::vector<Rect>& openings) {
    if (openings.empty()) return;
    out_ << "    " << key << ": [";
    for (std::size_t i = 0; i < openings.size(); ++i)
      out_ << (i == 0 ? "" : ", ") << list(openings[i]);
    out_ << "]\n";
  }

  void write(const Entity& entity) {
    out_ << "  - {id: " << entity.id << ", model: " << entity.model;
    if (entity.path) {
      const AgentPath& p = *entity.path;
      out_ << ", path: {from: " << list(p.from) << ", to: " << list(p.to)
           << ", speed: " << n(p.speed_m_s) << ", turn_s: " << n(p.turn_s)
           << ", phase_s: " << n(p.phase_s) << "}";
    } else {
      out_ << ", at: " << list(entity.at) << ", yaw_deg: " << degrees(entity.yaw_rad);
    }
    if (entity.floor_z_m != 0.0) out_ << ", floor_z: " << n(entity.floor_z_m);
    if (entity.size) out_ << ", size: " << list(*entity.size);
    out_ << ", tags: [";
    for (std::size_t i = 0; i < entity.tag_ids.size(); ++i)
      out_ << (i == 0 ? "" : ", ") << entity.tag_ids[i];
    out_ << "]}\n";
  }

  void write(const Robot& robot) {
    out_ << "\nrobot:\n  carrier: " << (robot.carrier == Carrier::kWheels ? "wheels" : "hand")
         << "\n  speed: " << n(robot.speed_m_s)
         << "\n  turn_rate_deg_s: " << degrees(robot.turn_rate_rad_s)
         << "\n  base_height: " << n(robot.base_height_m) << "\n  radius: " << n(robot.radius_m)
         << "\n  height: " << n(robot.height_m) << "\n  laps: " << robot.laps << "\n  route:\n";
    for (const RoutePoint& point : robot.route) {
      out_ << "    - {at: "
           << (point.at.z() == 0.0 ? list(Vector2(point.at.head<2>())) : list(point.at));
      if (point.wait_s > 0) out_ << ", wait_s: " << n(point.wait_s);
      out_ << "}\n";
    }
  }

  void writeSensors() {
    out_ << "\nsensors:\n";
    std::istringstream lines(toYaml(world_.sensors));
    for (std::string line; std::getline(lines, line);)
      out_ << (line.empty() ? "" : "  ") << line << "\n";
  }

  const World& world_;
  std::ostringstream out_;
};

}  // namespace

World readWorld(const std::filesystem::path& file) { return parseTop(YamlPlace::file(file)); }

World parseWorld(const std::string& yaml, const std::string& origin) {
  return parseTop(YamlPlace::text(yaml, origin));
}

std::string worldYaml(const World& world) { return Writer(world).text(); }

}  // namespace dynemo::simulation
