#include "dynemo/simulation/solids.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "dynemo/core/error.h"

namespace dynemo::simulation {
namespace {

constexpr double kSlab_m = 0.2;
/// Printed sheets lie this far in front of what they stick to.
constexpr double kSheetGap_m = 0.001;
constexpr double kHumanOrigin_m = 1.0, kChairOrigin_m = 0.45, kQuadrupedOrigin_m = 0.45;

Colour colour(double blue, double green, double red) {
  return Colour(static_cast<float>(blue), static_cast<float>(green), static_cast<float>(red));
}

/// One of several colours; neighbours in the list differ.
Colour fromPalette(int index) {
  static const std::array<Colour, 8> palette{
      colour(.78, .55, .30), colour(.35, .62, .40), colour(.40, .45, .80), colour(.60, .40, .62),
      colour(.35, .68, .72), colour(.70, .68, .38), colour(.45, .52, .58), colour(.62, .58, .80)};
  return palette[static_cast<std::size_t>(index) % palette.size()];
}

Box makeBox(const Vector3& centre, const Vector3& size, const Colour& tint, std::string name = {}) {
  Box box;
  box.T_body_box = Pose3::translation(centre);
  box.half = 0.5 * size;
  box.colour = tint;
  box.name = std::move(name);
  return box;
}

// ---- buildings ----

/// The rectangle without the openings, as rectangles between all their edges.
std::vector<Rect> without(const Rect& outline, const std::vector<Rect>& openings) {
  if (openings.empty()) return {outline};
  std::vector<double> xs{outline.x_min, outline.x_max}, ys{outline.y_min, outline.y_max};
  for (const Rect& o : openings) {
    for (const double x : {o.x_min, o.x_max})
      xs.push_back(std::clamp(x, outline.x_min, outline.x_max));
    for (const double y : {o.y_min, o.y_max})
      ys.push_back(std::clamp(y, outline.y_min, outline.y_max));
  }
  for (auto* list : {&xs, &ys}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  std::vector<Rect> pieces;
  for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
    for (std::size_t j = 0; j + 1 < ys.size(); ++j) {
      const Vector2 middle(0.5 * (xs[i] + xs[i + 1]), 0.5 * (ys[j] + ys[j + 1]));
      const bool open = std::any_of(openings.begin(), openings.end(),
                                    [&](const Rect& o) { return o.contains(middle); });
      if (!open) pieces.push_back({xs[i], ys[j], xs[i + 1], ys[j + 1]});
    }
  }
  return pieces;
}

void addSlab(const Rect& outline, const std::vector<Rect>& openings, double bottom_m, double top_m,
             const Box& style, Body& body) {
  for (const Rect& r : without(outline, openings)) {
    Box box = style;
    box.T_body_box = Pose3::translation(0.5 * (r.x_min + r.x_max), 0.5 * (r.y_min + r.y_max),
                                        0.5 * (bottom_m + top_m));
    box.half = 0.5 * Vector3(r.x_max - r.x_min, r.y_max - r.y_min, top_m - bottom_m);
    body.boxes.push_back(box);
  }
}

struct WallPiece {
  double begin_m, end_m, bottom_m, top_m;
};

/// What the doors leave of a wall: full-height pieces and lintels.
std::vector<WallPiece> wallPieces(const Wall& wall, const Storey& storey) {
  const double length_m = (wall.to - wall.from).norm();
  std::vector<Door> doors = wall.doors;
  std::sort(doors.begin(), doors.end(),
            [](const Door& a, const Door& b) { return a.at_m < b.at_m; });
  std::vector<WallPiece> pieces;
  double at_m = 0.0;
  for (const Door& door : doors) {
    const double begin_m = door.at_m - 0.5 * door.width_m, end_m = door.at_m + 0.5 * door.width_m;
    pieces.push_back({at_m, begin_m, storey.floor_z_m, storey.ceiling_z_m});
    pieces.push_back({begin_m, end_m, storey.floor_z_m + door.height_m, storey.ceiling_z_m});
    at_m = end_m;
  }
  pieces.push_back({at_m, length_m, storey.floor_z_m, storey.ceiling_z_m});
  std::erase_if(pieces, [](const WallPiece& p) {
    return p.end_m - p.begin_m < 1e-6 || p.top_m - p.bottom_m < 1e-6;
  });
  return pieces;
}

void addWall(const Wall& wall, const Storey& storey, const std::string& name, Body& body) {
  const Vector2 along = (wall.to - wall.from).normalized();
  const double yaw_rad = std::atan2(along.y(), along.x());
  for (const WallPiece& piece : wallPieces(wall, storey)) {
    const Vector2 middle = wall.from + 0.5 * (piece.begin_m + piece.end_m) * along;
    Box box;
    box.T_body_box = Pose3::fromYawPitchRoll(middle.x(), middle.y(),
                                             0.5 * (piece.bottom_m + piece.top_m), yaw_rad, 0, 0);
    box.half =
        0.5 * Vector3(piece.end_m - piece.begin_m, wall.thickness_m, piece.top_m - piece.bottom_m);
    box.colour = colour(.74, .70, .66);
    box.texture = Texture::kWall;
    box.name = name;
    body.boxes.push_back(box);
  }
}

void addRamp(const Ramp& ramp, const std::string& name, Body& body) {
  const Vector3 run = ramp.to - ramp.from;
  const Vector2 along = run.head<2>().normalized();
  const double yaw_rad = std::atan2(along.y(), along.x()), length_m = run.head<2>().norm();
  const auto add = [&](const Pose3& T, const Vector3& half) {
    Box box;
    box.T_body_box = T;
    box.half = half;
    box.colour = colour(.52, .54, .56);
    box.texture = Texture::kPanels;
    box.name = name;
    box.walkable = true;
    body.boxes.push_back(box);
  };
  if (ramp.steps == 0) {
    const Pose3 T_world_slope = Pose3::fromYawPitchRoll(ramp.from.x(), ramp.from.y(), ramp.from.z(),
                                                        yaw_rad, -std::atan2(run.z(), length_m), 0);
    const double thickness_m = 0.1;
    add(T_world_slope * Pose3::translation(0.5 * run.norm(), 0, -0.5 * thickness_m),
        0.5 * Vector3(run.norm(), ramp.width_m, thickness_m));
    return;
  }
  const double tread_m = length_m / ramp.steps, rise_m = run.z() / ramp.steps;
  for (int i = 0; i < ramp.steps; ++i) {
    const double low_m = std::min(ramp.from.z(), ramp.to.z());
    const double top_m = ramp.from.z() + rise_m * (run.z() > 0 ? i + 1 : i);
    const double height_m = std::max(top_m - low_m, 0.02);
    const Vector2 middle = ramp.from.head<2>() + (i + 0.5) * tread_m * along;
    add(Pose3::fromYawPitchRoll(middle.x(), middle.y(), low_m + 0.5 * height_m, yaw_rad, 0, 0),
        0.5 * Vector3(tread_m, ramp.width_m, height_m));
  }
}

// ---- furniture, in its own frame with the floor at z = 0 ----

using FurnitureParts = std::function<void(const Vector3& size, const Colour& tint, Body& out)>;

void addLegs(const Vector3& size, double leg_m, double height_m, const Colour& tint, Body& out) {
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      out.boxes.push_back(
          makeBox({x * 0.5 * (size.x() - leg_m), y * 0.5 * (size.y() - leg_m), 0.5 * height_m},
                  {leg_m, leg_m, height_m}, tint));
    }
  }
}

void cabinet(const Vector3& size, const Colour& tint, Body& out) {
  out.boxes.push_back(makeBox({0, 0, 0.5 * size.z()}, size, tint));
}

void table(const Vector3& size, const Colour& tint, Body& out) {
  constexpr double kTop_m = 0.04, kLeg_m = 0.06;
  out.boxes.push_back(makeBox({0, 0, size.z() - 0.5 * kTop_m}, {size.x(), size.y(), kTop_m}, tint));
  addLegs(size, kLeg_m, size.z() - kTop_m, 0.7f * tint, out);
}

void shelf(const Vector3& size, const Colour& tint, Body& out) {
  constexpr double kBoard_m = 0.03;
  const int boards = std::max(2, static_cast<int>(std::lround(size.z() / 0.4)) + 1);
  for (const double x : {-1.0, 1.0})
    out.boxes.push_back(makeBox({x * 0.5 * (size.x() - kBoard_m), 0, 0.5 * size.z()},
                                {kBoard_m, size.y(), size.z()}, tint));
  out.boxes.push_back(makeBox({0, -0.5 * (size.y() - kBoard_m), 0.5 * size.z()},
                              {size.x() - 2 * kBoard_m, kBoard_m, size.z()}, 0.8f * tint));
  for (int i = 0; i < boards; ++i) {
    const double z = 0.5 * kBoard_m + i * (size.z() - kBoard_m) / (boards - 1);
    out.boxes.push_back(makeBox({0, 0.5 * kBoard_m, z},
                                {size.x() - 2 * kBoard_m, size.y() - kBoard_m, kBoard_m}, tint));
  }
}

void sofa(const Vector3& size, const Colour& tint, Body& out) {
  const double seat_m = 0.45 * size.z(), arm_m = 0.15, back_m = 0.2;
  out.boxes.push_back(makeBox({0, 0, 0.5 * seat_m}, {size.x(), size.y(), seat_m}, tint));
  out.boxes.push_back(makeBox({0, -0.5 * (size.y() - back_m), 0.5 * (size.z() + seat_m)},
                              {size.x(), back_m, size.z() - seat_m}, 0.9f * tint));
  for (const double x : {-1.0, 1.0})
    out.boxes.push_back(makeBox({x * 0.5 * (size.x() - arm_m), 0.5 * back_m, seat_m + 0.1},
                                {arm_m, size.y() - back_m, 0.2}, 0.85f * tint));
}

void seatWithBack(double width_m, double seat_m, double back_m, const Colour& tint, Body& out) {
  constexpr double kPlate_m = 0.04, kLeg_m = 0.04;
  out.boxes.push_back(makeBox({0, 0, seat_m - 0.5 * kPlate_m}, {width_m, width_m, kPlate_m}, tint));
  out.boxes.push_back(makeBox({-0.5 * (width_m - kPlate_m), 0, seat_m + 0.5 * back_m},
                              {kPlate_m, width_m, back_m}, tint));
  addLegs({width_m, width_m, seat_m}, kLeg_m, seat_m - kPlate_m, 0.5f * tint, out);
}

void plainChair(const Vector3& size, const Colour& tint, Body& out) {
  seatWithBack(size.x(), 0.5 * size.z(), 0.5 * size.z(), tint, out);
}

const std::map<std::string, FurnitureParts>& furnitureParts() {
  static const std::map<std::string, FurnitureParts> table_of{{"cabinet", cabinet},
                                                              {"table", table},
                                                              {"shelf", shelf},
                                                              {"sofa", sofa},
                                                              {"chair", plainChair}};
  return table_of;
}

void addFurniture(const Furniture& item, const Storey& storey, const std::string& name, int index,
                  Body& body) {
  Body parts;
  furnitureParts().at(item.model)(item.size, fromPalette(index), parts);
  const Pose3 T_world_item =
      Pose3::fromYawPitchRoll(item.at.x(), item.at.y(), storey.floor_z_m, item.yaw_rad, 0, 0);
  for (Box& box : parts.boxes) {
    box.T_body_box = T_world_item * box.T_body_box;
    box.texture = Texture::kPanels;
    box.name = name;
    body.boxes.push_back(box);
  }
}

// ---- entities, in their own frame ----

/// A sheet on a face: `outward` is the face's normal, `up` the upright tag's upward direction.
TagSheet sheet(int tag_id, double size_m, const std::string& side, const Vector3& centre,
               const Vector3& outward, const Vector3& up = Vector3::UnitZ()) {
  TagSheet tag{tag_id, size_m, side, {}};
  const Vector3 z = -outward, y = -up;
  tag.T_body_tag.R << y.cross(z), y, z;
  tag.T_body_tag.t = centre + kSheetGap_m * outward;
  return tag;
}

void addSideTags(const Entity& entity, const Vector3& half, double z_m, double front_m,
                 double side_m, Body& body) {
  body.tags.push_back(
      sheet(entity.tag_ids[0], front_m, "front", {half.x(), 0, z_m}, Vector3::UnitX()));
  body.tags.push_back(
      sheet(entity.tag_ids[1], front_m, "back", {-half.x(), 0, z_m}, -Vector3::UnitX()));
  body.tags.push_back(
      sheet(entity.tag_ids[2], side_m, "left", {0, half.y(), z_m}, Vector3::UnitY()));
  body.tags.push_back(
      sheet(entity.tag_ids[3], side_m, "right", {0, -half.y(), z_m}, -Vector3::UnitY()));
}

Body boxEntity(const Entity& entity) {
  Body body;
  const Vector3 size = entity.size.value_or(Vector3(0.5, 0.5, 0.5));
  body.boxes.push_back(makeBox(Vector3::Zero(), size, fromPalette(entity.id)));
  // The sheet has 10/8 of the tag's size and must fit on the smallest face.
  const double tag_m = 0.05 * std::floor(0.72 * size.minCoeff() / 0.05);
  addSideTags(entity, 0.5 * size, 0.0, tag_m, tag_m, body);
  return body;
}

Body chairEntity(const Entity& entity) {
  constexpr double kWidth_m = 0.46, kSeat_m = 0.45, kBack_m = 0.5, kTag_m = 0.3, kSideTag_m = 0.16;
  constexpr double kApron_m = 0.22;
  Body body;
  const Colour tint = fromPalette(entity.id);
  seatWithBack(kWidth_m, kSeat_m, kBack_m, tint, body);
  for (const double y : {-1.0, 1.0})
    body.boxes.push_back(makeBox({0, y * 0.5 * (kWidth_m - 0.02), kSeat_m - 0.04 - 0.5 * kApron_m},
                                 {kWidth_m - 0.1, 0.02, kApron_m}, 0.8f * tint));
  for (Box& box : body.boxes) box.T_body_box.t.z() -= kChairOrigin_m;
  const double back_z_m = 0.5 * kBack_m, x_m = 0.5 * kWidth_m;
  const double side_z_m = -0.04 - 0.5 * kApron_m;
  body.tags = {
      sheet(entity.tag_ids[0], kTag_m, "front", {-x_m + 0.04, 0, back_z_m}, Vector3::UnitX()),
      sheet(entity.tag_ids[1], kTag_m, "back", {-x_m, 0, back_z_m}, -Vector3::UnitX()),
      sheet(entity.tag_ids[2], kSideTag_m, "left", {0, x_m, side_z_m}, Vector3::UnitY()),
      sheet(entity.tag_ids[3], kSideTag_m, "right", {0, -x_m, side_z_m}, -Vector3::UnitY())};
  return body;
}

Body humanEntity(const Entity& entity) {
  Body body;
  const Colour shirt = fromPalette(entity.id), trousers = 0.7f * fromPalette(entity.id / 3 + 5);
  const Vector3 torso(0.27, 0.46, 0.62);
  constexpr double kTorso_m = 0.18;
  body.boxes.push_back(makeBox({0, 0, kTorso_m}, torso, shirt));
  body.boxes.push_back(makeBox({0, 0, 0.62}, {0.2, 0.16, 0.26}, colour(.45, .55, .75)));
  for (const double y : {-1.0, 1.0})
    body.boxes.push_back(makeBox({0, y * 0.11, -0.565}, {0.18, 0.17, 0.87}, trousers));
  addSideTags(entity, 0.5 * torso, kTorso_m, 0.3, 0.2, body);
  return body;
}

Body quadrupedEntity(const Entity& entity) {
  Body body;
  const Vector3 trunk(0.7, 0.3, 0.28);
  body.boxes.push_back(makeBox(Vector3::Zero(), trunk, colour(.25, .55, .85)));
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0})
      body.boxes.push_back(
          makeBox({x * 0.3, y * 0.11, -0.295}, {0.06, 0.06, 0.31}, colour(.3, .3, .3)));
  }
  addSideTags(entity, 0.5 * trunk, 0.0, 0.2, 0.2, body);
  body.tags.push_back(sheet(entity.tag_ids[4], 0.22, "top", {0, 0, 0.5 * trunk.z()},
                            Vector3::UnitZ(), Vector3::UnitX()));
  return body;
}

}  // namespace

bool Rect::contains(const Vector2& p, double margin_m) const {
  return p.x() >= x_min + margin_m && p.x() <= x_max - margin_m && p.y() >= y_min + margin_m &&
         p.y() <= y_max - margin_m;
}

const Entity* World::findEntity(int id) const {
  const auto it =
      std::find_if(entities.begin(), entities.end(), [id](const Entity& e) { return e.id == id; });
  return it == entities.end() ? nullptr : &*it;
}

Body staticBody(const World& world) {
  Body body;
  int index = 0;
  for (const Storey& storey : world.storeys) {
    Box floor;
    floor.colour = colour(.50, .56, .60);
    floor.texture = Texture::kTiles;
    floor.name = storey.name + ": floor";
    floor.walkable = true;
    addSlab(storey.outline, storey.floor_openings, storey.floor_z_m - kSlab_m, storey.floor_z_m,
            floor, body);
    Box ceiling;
    ceiling.colour = colour(.80, .80, .80);
    ceiling.texture = Texture::kTiles;
    ceiling.name = storey.name + ": ceiling";
    addSlab(storey.outline, storey.ceiling_openings, storey.ceiling_z_m,
            storey.ceiling_z_m + 0.5 * kSlab_m, ceiling, body);
    for (std::size_t i = 0; i < storey.walls.size(); ++i)
      addWall(storey.walls[i], storey, storey.name + ": wall " + std::to_string(i), body);
    for (const Furniture& item : storey.furniture) {
      addFurniture(item, storey, storey.name + ": " + item.model, index, body);
      ++index;
    }
    for (std::size_t i = 0; i < storey.ramps.size(); ++i)
      addRamp(storey.ramps[i], storey.name + ": ramp " + std::to_string(i), body);
  }
  return body;
}

const std::vector<EntityModelInfo>& entityModels() {
  static const std::vector<EntityModelInfo> models{{"box", false, true, 4},
                                                   {"chair", false, false, 4},
                                                   {"human", true, false, 4},
                                                   {"quadruped", true, false, 5}};
  return models;
}

const EntityModelInfo* findEntityModel(const std::string& name) {
  const auto& models = entityModels();
  const auto it = std::find_if(models.begin(), models.end(),
                               [&](const EntityModelInfo& m) { return m.name == name; });
  return it == models.end() ? nullptr : &*it;
}

std::vector<std::string> furnitureModels() {
  std::vector<std::string> names;
  for (const auto& [name, parts] : furnitureParts()) names.push_back(name);
  return names;
}

Body entityBody(const Entity& entity) {
  if (entity.model == "box") return boxEntity(entity);
  if (entity.model == "chair") return chairEntity(entity);
  if (entity.model == "human") return humanEntity(entity);
  if (entity.model == "quadruped") return quadrupedEntity(entity);
  throw ConfigError("unknown entity model '" + entity.model + "'");
}

double originHeight(const Entity& entity) {
  if (entity.model == "chair") return kChairOrigin_m;
  if (entity.model == "human") return kHumanOrigin_m;
  if (entity.model == "quadruped") return kQuadrupedOrigin_m;
  return 0.5 * entity.size.value_or(Vector3(0.5, 0.5, 0.5)).z();
}

std::pair<Vector3, Vector3> bounds(const Body& body) {
  Vector3 low = Vector3::Constant(1e9), high = Vector3::Constant(-1e9);
  for (const Box& box : body.boxes) {
    const Vector3 reach = box.T_body_box.R.cwiseAbs() * box.half;
    low = low.cwiseMin(box.T_body_box.t - reach);
    high = high.cwiseMax(box.T_body_box.t + reach);
  }
  return {low, high};
}

std::vector<TruePlane> truePlanes(const World& world) {
  std::vector<TruePlane> planes;
  const auto add = [&](const std::string& name, const Vector3& n, const Vector3& p,
                       const Storey& s) {
    planes.push_back({name, n, -n.dot(p), s.name});
  };
  for (const Storey& storey : world.storeys) {
    for (std::size_t i = 0; i < storey.walls.size(); ++i) {
      const Wall& wall = storey.walls[i];
      const Vector2 along = (wall.to - wall.from).normalized();
      const Vector3 left(-along.y(), along.x(), 0.0), from(wall.from.x(), wall.from.y(), 0.0);
      const std::string name = storey.name + ": wall " + std::to_string(i);
      add(name + " left", left, from + 0.5 * wall.thickness_m * left, storey);
      add(name + " right", -left, from - 0.5 * wall.thickness_m * left, storey);
    }
    add(storey.name + ": floor", Vector3::UnitZ(), {0, 0, storey.floor_z_m}, storey);
    add(storey.name + ": ceiling", -Vector3::UnitZ(), {0, 0, storey.ceiling_z_m}, storey);
  }
  return planes;
}

}  // namespace dynemo::simulation
