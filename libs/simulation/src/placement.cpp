#include "placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "dynemo/core/error.h"
#include "dynemo/simulation/entity_motion.h"
#include "dynemo/simulation/solids.h"
#include "tag_pattern.h"

namespace dynemo::simulation {
namespace {

constexpr double kStep_s = 0.1;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kObjectRadius_m = 0.38, kAgentRadius_m = 0.35, kGap_m = 0.08;
constexpr int kAttempts = 4000;

/// To tenths, hundredths, …, which a world file then shows.
double rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }
double randomYaw(Random& random) { return kDegree * std::round(random.uniform(-180, 180)); }

}  // namespace

Placement::Placement(World& world, Random& random)
    : world_(world),
      random_(random),
      robot_(world.robot, world.seed),
      solids_(obstacles(world)),
      free_tags_(kTagFamilySize) {
  for (double t_s = 0.0; t_s <= std::max(world.duration_s, robot_.end_s()); t_s += kStep_s)
    robot_at_.push_back(robot_.floorPoint(t_s));
  std::iota(free_tags_.begin(), free_tags_.end(), 0);
}

const Storey& Placement::randomStorey() {
  return world_.storeys[static_cast<std::size_t>(
      random_.integer(0, static_cast<int>(world_.storeys.size()) - 1))];
}

bool Placement::isFree(const Disc& disc, double route_clearance_m) const {
  if (obstacleWithin(solids_, disc.at, disc.radius_m + 0.02, disc.floor_z_m + 0.01,
                     disc.floor_z_m + 1.6))
    return false;
  const auto near = [&](const Disc& other) {
    return std::abs(other.floor_z_m - disc.floor_z_m) < 1.0 &&
           (other.at - disc.at).norm() < disc.radius_m + other.radius_m + kGap_m;
  };
  if (std::any_of(taken_.begin(), taken_.end(), near)) return false;
  const double clearance_m = disc.radius_m + route_clearance_m;
  return std::none_of(robot_at_.begin(), robot_at_.end(), [&](const Vector3& p) {
    return std::abs(p.z() - disc.floor_z_m) < 1.8 && (p.head<2>() - disc.at).norm() < clearance_m;
  });
}

Placement::Disc Placement::freePlace(double radius_m) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Storey& storey = randomStorey();
    const Rect& r = storey.outline;
    const Vector2 p(rounded(random_.uniform(r.x_min + radius_m, r.x_max - radius_m), 100),
                    rounded(random_.uniform(r.y_min + radius_m, r.y_max - radius_m), 100));
    const auto open = [&](const Rect& o) {
      return p.x() > o.x_min - radius_m && p.x() < o.x_max + radius_m &&
             p.y() > o.y_min - radius_m && p.y() < o.y_max + radius_m;
    };
    const bool on_stairs =
        std::any_of(storey.floor_openings.begin(), storey.floor_openings.end(), open) ||
        std::any_of(storey.ceiling_openings.begin(), storey.ceiling_openings.end(), open);
    const Disc disc{p, radius_m, storey.floor_z_m};
    if (!on_stairs && isFree(disc, world_.robot.radius_m + kGap_m)) return disc;
  }
  throw ConfigError(world_.name + ": no space left for the entities; try another seed");
}

void Placement::drawTags(Entity& entity, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (free_tags_.empty()) throw ConfigError(world_.name + ": more tags than the family has");
    const auto at =
        static_cast<std::size_t>(random_.integer(0, static_cast<int>(free_tags_.size()) - 1));
    entity.tag_ids.push_back(free_tags_[at]);
    free_tags_.erase(free_tags_.begin() + static_cast<std::ptrdiff_t>(at));
  }
}

void Placement::addObjects(const std::string& model, int count, int first_id) {
  const EntityModelInfo& info = *findEntityModel(model);
  for (int i = 0; i < count; ++i) {
    Entity entity;
    entity.id = first_id + i;
    entity.model = model;
    const Disc disc = freePlace(kObjectRadius_m);
    entity.at = disc.at;
    entity.floor_z_m = disc.floor_z_m;
    entity.yaw_rad = randomYaw(random_);
    if (info.sized) {
      entity.size = Vector3::Zero();
      for (double& side : *entity.size) side = rounded(random_.uniform(0.42, 0.52), 100);
      entity.size->z() = rounded(random_.uniform(0.42, 0.62), 100);
    }
    drawTags(entity, info.tags);
    taken_.push_back(disc);
    world_.entities.push_back(entity);
  }
}

bool Placement::meetsRobot(const AgentPath& path, double floor_z_m) const {
  Entity walker;
  walker.model = "human";
  walker.path = path;
  const EntityMotion motion(walker, {});
  const double apart_m = world_.robot.radius_m + kAgentRadius_m + 0.15;
  for (std::size_t i = 0; i < robot_at_.size(); ++i) {
    const Vector3& p = robot_at_[i];
    if (std::abs(p.z() - floor_z_m) > 1.8) continue;
    const Vector2 q = motion.at(static_cast<double>(i) * kStep_s).t.head<2>();
    if ((p.head<2>() - q).norm() < apart_m) return true;
  }
  return false;
}

void Placement::addAgents(const std::string& model, int count, int first_id) {
  const std::vector<Disc> objects = taken_;
  for (int i = 0; i < count; ++i) {
    Entity entity;
    entity.id = first_id + i;
    entity.model = model;
    drawTags(entity, findEntityModel(model)->tags);
    AgentPath path;
    bool placed = false;
    for (int attempt = 0; attempt < kAttempts && !placed; ++attempt) {
      const Storey& storey = randomStorey();
      const Rect& r = storey.outline;
      const double length_m = random_.uniform(2.0, 4.0),
                   yaw_rad = random_.uniform(-std::numbers::pi, std::numbers::pi);
      path.from = {rounded(random_.uniform(r.x_min, r.x_max), 100),
                   rounded(random_.uniform(r.y_min, r.y_max), 100)};
      path.to = path.from + Vector2(rounded(length_m * std::cos(yaw_rad), 100),
                                    rounded(length_m * std::sin(yaw_rad), 100));
      path.speed_m_s = rounded(random_.uniform(0.4, 1.0), 100);
      path.turn_s = rounded(random_.uniform(0.8, 1.6), 100);
      path.phase_s = rounded(random_.uniform(0.0, 20.0), 100);
      if (!r.contains(path.from, 0.5) || !r.contains(path.to, 0.5)) continue;
      placed = true;
      for (double s = 0.0; s <= 1.0 && placed; s += 0.05) {
        const Vector2 p = path.from + s * (path.to - path.from);
        placed = !obstacleWithin(solids_, p, kAgentRadius_m + 0.05, storey.floor_z_m + 0.01,
                                 storey.floor_z_m + 1.8) &&
                 std::none_of(objects.begin(), objects.end(), [&](const Disc& o) {
                   return (o.at - p).norm() < o.radius_m + kAgentRadius_m;
                 });
      }
      placed = placed && !meetsRobot(path, storey.floor_z_m);
      entity.floor_z_m = storey.floor_z_m;
    }
    if (!placed)
      throw ConfigError(world_.name + ": no space left for the agents; try another seed");
    entity.path = path;
    world_.entities.push_back(entity);
  }
}

bool Placement::isSeen(const Vector3& p, double t_s) const {
  constexpr double kFarthest_m = 14.0, kHalfAngle = 52.0 * kDegree;
  const Pose3 T = robot_.at(t_s) * T_base_camera(world_.sensors.camera);
  const Vector3 q = T.inverse() * p;
  if (q.norm() > kFarthest_m || std::acos(std::clamp(q.z() / q.norm(), -1.0, 1.0)) > kHalfAngle)
    return false;
  return !isBlocked(solids_, T.t, p + Vector3(0, 0, 0.2));
}

bool Placement::slidesFreely(const Vector2& from, const Vector2& to, double radius_m, double time_s,
                             double duration_s) const {
  for (double u = 0.0; u <= 1.0; u += 0.02) {
    const Vector2 p = from + u * (to - from);
    if (obstacleWithin(solids_, p, radius_m + 0.02, 0.01, 1.6)) return false;
    for (double t_s = time_s - 1.0; t_s <= time_s + duration_s + 1.0; t_s += 0.2)
      if ((robot_.floorPoint(t_s).head<2>() - p).norm() < radius_m + world_.robot.radius_m + 0.3)
        return false;
    for (const Disc& disc : taken_) {
      if ((disc.at - from).norm() > 1e-6 && (disc.at - to).norm() > 1e-6 &&
          (disc.at - p).norm() < radius_m + disc.radius_m)
        return false;
    }
  }
  return true;
}

void Placement::relocateObjects(int count, double from_s, double to_s, bool rotate, bool in_view) {
  for (int i = 0; i < count; ++i) {
    const Entity& entity = world_.entities[static_cast<std::size_t>(i)];
    Relocation relocation;
    relocation.entity = entity.id;
    relocation.to = entity.at;
    relocation.yaw_rad = kDegree * std::round(entity.yaw_rad / kDegree + random_.uniform(60, 170));
    if (!rotate) {
      Disc disc = freePlace(kObjectRadius_m);
      while (disc.floor_z_m != entity.floor_z_m) disc = freePlace(kObjectRadius_m);
      taken_.push_back(disc);
      relocation.to = disc.at;
    }
    const double z_m = entity.floor_z_m + originHeight(entity);
    const Vector3 before(entity.at.x(), entity.at.y(), z_m),
        after(relocation.to.x(), relocation.to.y(), z_m);
    const double earliest_s = from_s + (to_s - from_s) * i / count;
    relocation.time_s = rounded(earliest_s, 10);
    for (double t_s = relocation.time_s; t_s < to_s + 0.5 * (to_s - from_s); t_s += 0.5) {
      const bool seen = isSeen(before, t_s) || isSeen(after, t_s);
      if (in_view && i % 2 == 1) {
        const double duration_s = rotate ? 2.5 : 3.5;
        if (!seen || !slidesFreely(entity.at, relocation.to, kObjectRadius_m, t_s, duration_s))
          continue;
        relocation.duration_s = duration_s;
      } else if (seen) {
        continue;
      }
      relocation.time_s = rounded(t_s, 10);
      break;
    }
    world_.relocations.push_back(relocation);
  }
  std::stable_sort(world_.relocations.begin(), world_.relocations.end(),
                   [](const Relocation& a, const Relocation& b) { return a.time_s < b.time_s; });
}

}  // namespace dynemo::simulation
