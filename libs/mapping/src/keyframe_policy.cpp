#include "dynemo/mapping/keyframe_policy.h"

#include "dynemo/core/noise.h"

namespace dynemo {

void fields(FieldVisitor& v, KeyframeParams& p) {
  v.choice("mode", p.mode, {"baseline", "dynamic"},
           "Robot motion only, or also new and moved entities");
  v.choice(
      "deskew", p.deskew, {"none", "past", "next_frame"},
      "Motion that straightens a keyframe's sweep, where its odometry did not measure it: none, "
      "since the last frame, or until the next, for which the keyframe waits");
  v.number("robot_translation_m", p.robot_translation_m,
           "Eq. (1): robot translation since the last keyframe", Range::positive());
  v.angle("robot_rotation_deg", p.robot_rotation_rad,
          "Eq. (1): robot rotation since the last keyframe", Range::positive());
  v.number("object_translation_m", p.object_translation_m,
           "Eq. (3): displacement of a mapped object", Range::positive());
  v.angle("object_rotation_deg", p.object_rotation_rad, "Eq. (3): rotation of a mapped object",
          Range::positive());
  v.number("agent_translation_m", p.agent_translation_m, "Eq. (3): displacement of a mapped agent",
           Range::positive());
  v.number("entity_sigmas", p.entity_sigmas,
           "Eq. (3): and by so many standard deviations of the detection", Range::nonNegative());
  v.flag("timer", p.timer, "A static object seen again after timer_s makes a keyframe");
  v.number("timer_s", p.timer_s, "Since its last registered observation", Range::positive());
  v.integer("confirmations", p.confirmations,
            "Consistent detections before a new or moved entity counts", Range::between(1, 100));
  v.number("confirmation_window_s", p.confirmation_window_s,
           "Time between two detections that confirm each other", Range::positive());
  v.number("min_interval_s", p.min_interval_s, "Least time between keyframes that entities trigger",
           Range::nonNegative());
}

bool KeyframePolicy::robotMoved(const KeyframeCandidate& frame, const CNodeKeyframe& last) const {
  const Pose3 T_last_now = last.T_odom_base.inverse() * frame.T_odom_base;
  return T_last_now.t.norm() >= params_.robot_translation_m ||
         rotationAngle(T_last_now) >= params_.robot_rotation_rad;
}

bool KeyframePolicy::entityMoved(const EntityObservation& observation, const Pose3& T_map_entity,
                                 const CNodeEntity& last) const {
  const Vector6 d = local(last.T_map_entity(), T_map_entity);
  const double translation_m = d.head<3>().norm(), rotation_rad = d.tail<3>().norm();
  const bool agent = observation.semantic_class == SemanticClass::kAgent;
  const bool far = agent ? translation_m > params_.agent_translation_m
                         : translation_m > params_.object_translation_m ||
                               rotation_rad > params_.object_rotation_rad;
  return far && squaredMahalanobis(d, observation.covariance) >
                    params_.entity_sigmas * params_.entity_sigmas;
}

bool KeyframePolicy::confirm(const EntityObservation& observation, const Pose3& T_map_entity) {
  Sighting& sighting = unconfirmed_[observation.entity];
  const bool recent = sighting.count > 0 && secondsBetween(sighting.last, observation.stamp) <=
                                                params_.confirmation_window_s;
  // An object that is carried, or a flipped pose, is not at the same place twice; agents walk on.
  const bool consistent =
      recent &&
      (observation.semantic_class == SemanticClass::kAgent ||
       ((sighting.T_map_entity.t - T_map_entity.t).norm() <= params_.object_translation_m &&
        rotationAngle(sighting.T_map_entity.inverse() * T_map_entity) <=
            params_.object_rotation_rad));
  sighting.count = consistent ? sighting.count + 1 : 1;
  sighting.last = observation.stamp;
  sighting.T_map_entity = T_map_entity;
  return sighting.count >= params_.confirmations;
}

std::uint32_t KeyframePolicy::decide(const KeyframeCandidate& frame, const CSceneGraph& graph) {
  const auto bit = [](KeyframeReason reason) { return static_cast<std::uint32_t>(reason); };
  if (graph.keyframes().empty()) return bit(KeyframeReason::kFirst);
  const CNodeKeyframe& last = *graph.keyframes().back();

  std::uint32_t reasons = robotMoved(frame, last) ? bit(KeyframeReason::kRobotMoved) : 0;
  if (params_.mode == KeyframeMode::kBaseline) return reasons;

  std::uint32_t entity_reasons = 0;
  for (const EntityObservation& observation : frame.observations) {
    const Pose3 T_map_entity = frame.T_map_base * observation.T_base_entity;
    const CNodeEntity* mapped = graph.lastObservation(observation.entity);
    if (!mapped) {
      if (confirm(observation, T_map_entity)) entity_reasons |= bit(KeyframeReason::kNewEntity);
    } else if (entityMoved(observation, T_map_entity, *mapped)) {
      if (confirm(observation, T_map_entity)) entity_reasons |= bit(KeyframeReason::kEntityMoved);
    } else {
      unconfirmed_.erase(observation.entity);
      if (params_.timer && observation.semantic_class == SemanticClass::kObject &&
          secondsBetween(mapped->stamp, observation.stamp) >= params_.timer_s) {
        entity_reasons |= bit(KeyframeReason::kTimerExpired);
      }
    }
  }
  if (secondsBetween(last.stamp, frame.stamp) >= params_.min_interval_s) reasons |= entity_reasons;
  return reasons;
}

}  // namespace dynemo
