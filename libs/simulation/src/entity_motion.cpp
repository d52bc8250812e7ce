#include "dynemo/simulation/entity_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynemo/simulation/solids.h"

namespace dynemo::simulation {

EntityMotion::EntityMotion(const Entity& entity, const std::vector<Relocation>& relocations)
    : path_(entity.path), z_m_(entity.floor_z_m + originHeight(entity)) {
  placements_.push_back({-1e9, 0.0, entity.at, entity.yaw_rad});
  for (const Relocation& r : relocations) {
    if (r.entity == entity.id) placements_.push_back({r.time_s, r.duration_s, r.to, r.yaw_rad});
  }
}

Pose3 EntityMotion::at(double t_s) const { return path_ ? agentAt(t_s) : objectAt(t_s); }

Pose3 EntityMotion::agentAt(double t_s) const {
  const Vector2 way = path_->to - path_->from;
  const double walk_s = way.norm() / path_->speed_m_s, half_s = walk_s + path_->turn_s;
  double t = std::fmod(t_s + path_->phase_s, 2.0 * half_s);
  if (t < 0.0) t += 2.0 * half_s;
  const bool back = t >= half_s;
  if (back) t -= half_s;
  const double s = std::min(t / walk_s, 1.0);
  const Vector2 p = path_->from + (back ? 1.0 - s : s) * way;
  double yaw_rad = std::atan2(way.y(), way.x()) + (back ? std::numbers::pi : 0.0);
  if (t > walk_s) {
    const double u = (t - walk_s) / path_->turn_s;
    yaw_rad += std::numbers::pi * u * u * (3.0 - 2.0 * u);
  }
  return Pose3::fromYawPitchRoll(p.x(), p.y(), z_m_, yaw_rad, 0, 0);
}

Pose3 EntityMotion::objectAt(double t_s) const {
  // Times are whole microseconds elsewhere.
  constexpr double kHalfTick_s = 0.5e-6;
  std::size_t last = 0;
  while (last + 1 < placements_.size() && placements_[last + 1].time_s <= t_s + kHalfTick_s) ++last;
  const Placement& now = placements_[last];
  Vector2 p = now.at;
  double yaw_rad = now.yaw_rad;
  if (now.duration_s > 0.0 && t_s < now.time_s + now.duration_s) {
    const Placement& before = placements_[last - 1];
    const double u = std::max(t_s - now.time_s, 0.0) / now.duration_s, s = u * u * (3.0 - 2.0 * u);
    p = before.at + s * (now.at - before.at);
    yaw_rad =
        before.yaw_rad + s * std::remainder(now.yaw_rad - before.yaw_rad, 2.0 * std::numbers::pi);
  }
  return Pose3::fromYawPitchRoll(p.x(), p.y(), z_m_, yaw_rad, 0, 0);
}

}  // namespace dynemo::simulation
