#include "floor_plans.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dynemo::simulation {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

void addOuterWalls(const Rect& r, Storey& storey) {
  const Vector2 a(r.x_min, r.y_min), b(r.x_max, r.y_min), c(r.x_max, r.y_max), d(r.x_min, r.y_max);
  for (const auto& [from, to] :
       {std::pair(a, b), std::pair(b, c), std::pair(c, d), std::pair(d, a)}) {
    Wall wall;
    wall.from = from;
    wall.to = to;
    storey.walls.push_back(wall);
  }
}

Wall wallWithDoors(const Vector2& from, const Vector2& to, std::vector<Door> doors) {
  Wall wall;
  wall.from = from;
  wall.to = to;
  wall.doors = std::move(doors);
  return wall;
}

Storey storeyOf(const std::string& name, const Rect& outline, double height_m) {
  Storey storey;
  storey.name = name;
  storey.outline = outline;
  storey.ceiling_z_m = height_m;
  addOuterWalls(outline, storey);
  return storey;
}

RoutePoint point(double x, double y, double wait_s = 0.0, double z = 0.0) {
  return {{x, y, z}, wait_s};
}

double distanceToRoute(const std::vector<RoutePoint>& lap, const Rect& r) {
  double nearest_m = 1e9;
  for (std::size_t i = 0; i < lap.size(); ++i) {
    const Vector3 &a = lap[i].at, &b = lap[(i + 1) % lap.size()].at;
    constexpr int kSteps = 40;
    for (int k = 0; k <= kSteps; ++k) {
      const Vector3 p = a + (b - a) * (static_cast<double>(k) / kSteps);
      const double dx = std::max({r.x_min - p.x(), p.x() - r.x_max, 0.0});
      const double dy = std::max({r.y_min - p.y(), p.y() - r.y_max, 0.0});
      nearest_m = std::min(nearest_m, std::hypot(dx, dy));
    }
  }
  return nearest_m;
}

/// Furniture along the walls of rooms: its back to the wall, out of the way of doors and of the
/// route.
class Furnisher {
 public:
  Furnisher(Random& random, const std::vector<RoutePoint>& lap, double clearance_m)
      : random_(random), lap_(lap), clearance_m_(clearance_m) {}

  void keepFree(const Vector2& p, double radius_m) {
    taken_.push_back({p.x() - radius_m, p.y() - radius_m, p.x() + radius_m, p.y() + radius_m});
  }

  void furnish(const Rect& room, int items, Storey& storey) {
    for (int i = 0; i < items; ++i) {
      for (int attempt = 0; attempt < 60; ++attempt) {
        const Furniture item = draw(room);
        const Rect r = outline(item);
        const bool overlaps = std::any_of(taken_.begin(), taken_.end(), [&](const Rect& t) {
          return r.x_min < t.x_max && t.x_min < r.x_max && r.y_min < t.y_max && t.y_min < r.y_max;
        });
        if (overlaps || distanceToRoute(lap_, r) < clearance_m_) continue;
        taken_.push_back({r.x_min - 0.1, r.y_min - 0.1, r.x_max + 0.1, r.y_max + 0.1});
        storey.furniture.push_back(item);
        break;
      }
    }
  }

 private:
  struct Kind {
    const char* model;
    Vector3 low, high;
  };

  static double rounded(double value) { return std::round(value * 100.0) / 100.0; }

  Furniture draw(const Rect& room) {
    static const std::array<Kind, 5> kinds{{{"table", {0.8, 0.5, 0.7}, {1.4, 0.6, 0.78}},
                                            {"shelf", {0.7, 0.25, 1.4}, {1.2, 0.35, 2.1}},
                                            {"cabinet", {0.5, 0.35, 0.8}, {1.0, 0.5, 1.9}},
                                            {"sofa", {1.3, 0.6, 0.75}, {1.6, 0.65, 0.85}},
                                            {"chair", {0.42, 0.42, 0.85}, {0.48, 0.48, 0.95}}}};
    const Kind& kind = kinds[static_cast<std::size_t>(random_.integer(0, 4))];
    Furniture item;
    item.model = kind.model;
    for (int i = 0; i < 3; ++i) item.size[i] = rounded(random_.uniform(kind.low[i], kind.high[i]));
    constexpr double kGap_m = 0.09;  // half a wall and a little
    const int side = random_.integer(0, 3);
    const double half_x = 0.5 * item.size.x() + kGap_m, half_y = 0.5 * item.size.y() + kGap_m;
    // The back is at −y: against the wall of that side.
    if (side == 0) {
      item.at = {random_.uniform(room.x_min + half_x, room.x_max - half_x), room.y_min + half_y};
    } else if (side == 1) {
      item.at = {room.x_max - half_y, random_.uniform(room.y_min + half_x, room.y_max - half_x)};
    } else if (side == 2) {
      item.at = {random_.uniform(room.x_min + half_x, room.x_max - half_x), room.y_max - half_y};
    } else {
      item.at = {room.x_min + half_y, random_.uniform(room.y_min + half_x, room.y_max - half_x)};
    }
    item.at = {rounded(item.at.x()), rounded(item.at.y())};
    item.yaw_rad = 0.5 * kHalfTurn * side;
    return item;
  }

  static Rect outline(const Furniture& item) {
    const bool turned = std::abs(std::sin(item.yaw_rad)) > 0.5;
    const double half_x = 0.5 * (turned ? item.size.y() : item.size.x());
    const double half_y = 0.5 * (turned ? item.size.x() : item.size.y());
    return {item.at.x() - half_x, item.at.y() - half_y, item.at.x() + half_x, item.at.y() + half_y};
  }

  Random& random_;
  const std::vector<RoutePoint>& lap_;
  double clearance_m_;
  std::vector<Rect> taken_;
};

/// From the corridor through a door, around the room and out again.
void visitRoom(const Rect& room, double door_x, double corridor_y, std::vector<RoutePoint>& lap) {
  constexpr double kMargin_m = 1.15;
  const bool above = room.y_min > corridor_y;
  const double y_near = above ? room.y_min + kMargin_m : room.y_max - kMargin_m;
  const double y_far = above ? room.y_max - kMargin_m : room.y_min + kMargin_m;
  const double left = room.x_min + kMargin_m, right = room.x_max - kMargin_m;
  lap.push_back(point(door_x, corridor_y));
  lap.push_back(point(door_x, y_near));
  lap.push_back(point(right, y_near));
  lap.push_back(point(right, y_far));
  lap.push_back(point(left, y_far));
  lap.push_back(point(left, y_near));
  lap.push_back(point(door_x, y_near));
  lap.push_back(point(door_x, corridor_y));
}

}  // namespace

FloorPlan furnishedRooms(Scale scale, Random& random) {
  const bool mini = scale == Scale::kMini;
  const Rect outline = mini ? Rect{0, 0, 9.0, 5.6} : Rect{0, 0, 13.1, 9.4};
  const double corridor_low = mini ? 4.0 : 3.9, corridor_high = mini ? 5.6 : 5.5;
  const double corridor_y = 0.5 * (corridor_low + corridor_high);
  const int columns = mini ? 2 : 3;
  const double width_m = outline.x_max / columns;
  Storey storey = storeyOf("ground", outline, 2.7);

  std::vector<Rect> rooms;
  std::vector<double> door_xs;
  for (const bool above : {false, true}) {
    if (above && mini) break;
    const double y = above ? corridor_high : corridor_low;
    std::vector<Door> doors;
    for (int i = 0; i < columns; ++i) {
      const double door_x = std::round((i + random.uniform(0.35, 0.65)) * width_m * 100) / 100;
      doors.push_back({door_x, 1.0, 2.1});
      door_xs.push_back(door_x);
      rooms.push_back(above ? Rect{i * width_m, y, (i + 1) * width_m, outline.y_max}
                            : Rect{i * width_m, 0, (i + 1) * width_m, y});
      if (i == 0) continue;
      const double x = i * width_m;
      storey.walls.push_back(above ? wallWithDoors({x, y}, {x, outline.y_max}, {})
                                   : wallWithDoors({x, 0}, {x, y}, {}));
    }
    storey.walls.push_back(wallWithDoors({0, y}, {outline.x_max, y}, doors));
  }

  FloorPlan plan;
  plan.robot_radius_m = 0.22;
  plan.lap.push_back(point(1.0, corridor_y));
  // Out along one side of the corridor, back along the other.
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const auto n = static_cast<std::size_t>(columns);
    const std::size_t room = i < n ? i : rooms.size() - 1 - (i - n);
    visitRoom(rooms[room], door_xs[room], corridor_y, plan.lap);
  }
  plan.lap.push_back(point(1.0, corridor_y));

  Furnisher furnisher(random, plan.lap, plan.robot_radius_m + 0.12);
  for (const double x : door_xs)
    for (const double y : {corridor_low, corridor_high}) furnisher.keepFree({x, y}, 0.8);
  for (const Rect& room : rooms) furnisher.furnish(room, 4, storey);
  plan.storeys = {storey};
  return plan;
}

FloorPlan largeRooms(Scale scale) {
  const bool mini = scale == Scale::kMini;
  const int rooms = mini ? 2 : 3;
  const double side_m = mini ? 9.0 : 15.0;
  const double low = mini ? 2.5 : 3.5, high = side_m - low, middle = 0.5 * side_m;
  Storey storey = storeyOf("ground", {0, 0, rooms * side_m, side_m}, 3.5);
  for (int i = 1; i < rooms; ++i)
    storey.walls.push_back(
        wallWithDoors({i * side_m, 0}, {i * side_m, side_m}, {{low, 2.0, 2.4}, {high, 2.0, 2.4}}));
  FloorPlan plan;
  const double end = rooms * side_m - low;
  plan.lap.push_back(point(low, low));
  for (int i = 0; i < rooms; ++i) {
    const double x = (i + 0.5) * side_m;
    plan.lap.push_back(point(x, low, mini ? 0.0 : 2.0));
    plan.lap.push_back(point(x, middle));
    plan.lap.push_back(point(x, low));
  }
  plan.lap.push_back(point(end, low));
  plan.lap.push_back(point(end, high, mini ? 0.0 : 3.0));
  for (int i = rooms - 1; i > 0; --i) plan.lap.push_back(point(i * side_m, high));
  plan.lap.push_back(point(low, high));
  plan.lap.push_back(point(low, low));
  plan.storeys = {storey};
  return plan;
}

FloorPlan oneRoom(Scale scale) {
  const double side_m = scale == Scale::kMini ? 9.0 : 15.0;
  const double low = scale == Scale::kMini ? 2.0 : 2.5, high = side_m - low, middle = 0.5 * side_m;
  FloorPlan plan;
  plan.lap = {point(low, low),    point(high, low),      point(high, high),  point(low, high),
              point(low, middle), point(middle, middle), point(middle, low), point(low, low)};
  plan.storeys = {storeyOf("ground", {0, 0, side_m, side_m}, 3.5)};
  return plan;
}

FloorPlan hall(Random& random) {
  const Rect outline{0, 0, 11.25, 8.0};
  Storey storey = storeyOf("ground", outline, 3.5);
  for (const Vector2& at : {Vector2(3.2, 4.0), Vector2(8.1, 4.0)})
    storey.furniture.push_back({"cabinet", at, 0.0, {0.4, 0.4, 3.5}});
  FloorPlan plan;
  plan.robot_radius_m = 0.25;
  plan.lap = {point(2.0, 2.0), point(9.3, 1.9), point(9.4, 6.0), point(5.7, 6.1),
              point(5.6, 3.0), point(2.0, 5.9), point(2.0, 2.0)};
  Furnisher furnisher(random, plan.lap, plan.robot_radius_m + 0.3);
  furnisher.furnish(outline, 9, storey);
  plan.storeys = {storey};
  return plan;
}

FloorPlan twoStoreys(Random& random) {
  const Rect outline{0, 0, 12.0, 8.0};
  constexpr double kRise_m = 3.06;
  const Rect stairwell{3.6, 5.9, 10.2, 7.9};
  Storey ground = storeyOf("ground", outline, kRise_m - 0.3);
  ground.ceiling_openings = {stairwell};
  ground.walls.push_back(wallWithDoors({6.0, 0}, {6.0, 5.0}, {{2.5, 1.0, 2.1}}));
  ground.ramps = {{{4.5, 6.9, 0}, {9.6, 6.9, kRise_m}, 1.6, 17}};
  Storey upper = storeyOf("upper", outline, kRise_m + 2.7);
  upper.floor_z_m = kRise_m;
  upper.floor_openings = {{3.6, 5.9, 9.6, 7.9}};
  upper.walls.push_back(wallWithDoors({6.0, 0}, {6.0, 5.0}, {{2.5, 1.2, 2.1}}));

  FloorPlan plan;
  plan.robot_radius_m = 0.25;
  const auto up = [&](double x, double y) { return point(x, y, 0.0, kRise_m); };
  plan.lap = {
      point(1.6, 4.5),  point(1.6, 1.5),  point(4.4, 1.5), point(4.4, 2.5), point(7.6, 2.5),
      point(10.4, 1.6), point(10.4, 4.6), point(7.5, 4.6), point(7.6, 2.5), point(4.4, 2.5),
      point(4.4, 4.4),  point(2.6, 5.2),  point(2.9, 6.9), point(4.5, 6.9), up(9.6, 6.9),
      up(10.9, 6.9),    up(10.8, 4.5),    up(7.4, 4.5),    up(7.4, 2.5),    up(4.6, 2.5),
      up(4.6, 1.4),     up(1.5, 1.4),     up(1.5, 4.6),    up(4.6, 4.6),    up(4.6, 2.5),
      up(7.4, 2.5),     up(7.4, 1.4),     up(10.8, 1.4),   up(10.8, 4.5),   up(10.9, 6.9),
      up(9.6, 6.9),     point(4.5, 6.9),  point(2.9, 6.9), point(2.6, 5.2), point(1.6, 4.5)};
  // Furniture may stand in neither storey where the route of either one goes.
  Furnisher furnisher(random, plan.lap, plan.robot_radius_m + 0.2);
  furnisher.keepFree({6.0, 2.5}, 0.9);
  const Rect rooms_low{0, 0, 12.0, 5.8};
  furnisher.furnish(rooms_low, 8, ground);
  furnisher.furnish(rooms_low, 6, upper);
  plan.storeys = {ground, upper};
  return plan;
}

}  // namespace dynemo::simulation
