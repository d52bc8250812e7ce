#include "dynemo/pipeline/agent_points.h"

#include <algorithm>

namespace dynemo {
namespace {

/// Positions closer in time say little about the velocity.
constexpr double kMinInterval_s = 0.05;

bool isAgent(const EntityObservation& observation) {
  return observation.semantic_class == SemanticClass::kAgent;
}

}  // namespace

void fields(FieldVisitor& v, AgentPointsParams& p) {
  v.flag("left_out", p.left_out, "LiDAR odometry leaves out the points on agents");
  v.number("radius_m", p.radius_m, "Radius of the upright cylinder around an agent",
           Range::positive());
  v.number("max_age_s", p.max_age_s,
           "For so long an agent that is out of sight is taken to walk on as it did",
           Range::nonNegative());
  v.number("growth_m_s", p.growth_m_s, "Growth of the radius while it is out of sight",
           Range::nonNegative());
}

std::vector<AgentPoints::Cylinder> AgentPoints::cylinders(
    const SensorFrame& frame, const std::vector<EntityObservation>& observations) const {
  std::vector<Cylinder> all;
  for (const EntityObservation& observation : observations) {
    if (isAgent(observation)) all.push_back({observation.T_base_entity.t, params_.radius_m});
  }
  if (!frame.odometry) return all;
  const Pose3 T_base_odom = frame.odometry->T_odom_base.inverse();
  for (const auto& [entity, track] : tracks_) {
    const double age_s = secondsBetween(track.stamp, frame.stamp);
    const bool seen = std::any_of(observations.begin(), observations.end(),
                                  [id = entity](const auto& o) { return o.entity == id; });
    if (seen || age_s > params_.max_age_s) continue;
    all.push_back({T_base_odom * (track.p_odom + age_s * track.velocity_m_s),
                   params_.radius_m + params_.growth_m_s * age_s});
  }
  return all;
}

PointIndices AgentPoints::of(const SensorFrame& frame,
                             const std::vector<EntityObservation>& observations) const {
  PointIndices indices;
  if (!frame.scan) return indices;
  const std::vector<Cylinder> agents = cylinders(frame, observations);
  if (agents.empty()) return indices;
  const Vector3 up =
      frame.odometry ? Vector3(frame.odometry->T_odom_base.R.row(2).transpose()) : Vector3::UnitZ();
  const PointCloud& cloud = frame.scan->cloud;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p_base = frame.scan->T_base_lidar * cloud.points[i].cast<double>();
    const bool inside = std::any_of(agents.begin(), agents.end(), [&](const Cylinder& agent) {
      const Vector3 d = p_base - agent.p_base;
      return (d - d.dot(up) * up).squaredNorm() < agent.radius_m * agent.radius_m;
    });
    if (inside) indices.push_back(i);
  }
  return indices;
}

void AgentPoints::remember(Stamp stamp, const Pose3& T_odom_base,
                           const std::vector<EntityObservation>& observations) {
  for (const EntityObservation& observation : observations) {
    if (!isAgent(observation)) continue;
    const Vector3 p_odom = T_odom_base * observation.T_base_entity.t;
    const auto [it, first] = tracks_.try_emplace(observation.entity, Track{stamp, p_odom});
    if (first) continue;
    Track& track = it->second;
    const double dt_s = secondsBetween(track.stamp, stamp);
    if (dt_s < kMinInterval_s) continue;
    track = {stamp, p_odom,
             dt_s > params_.max_age_s ? Vector3(Vector3::Zero())
                                      : Vector3((p_odom - track.p_odom) / dt_s)};
  }
}

}  // namespace dynemo
