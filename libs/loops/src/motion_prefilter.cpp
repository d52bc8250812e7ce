#include <algorithm>
#include <cstdio>

#include "prefilters.h"

namespace dynemo {
namespace {

std::string movedText(const Pose3& motion) {
  char text[64];
  std::snprintf(text, sizeof(text), "moved %.2f m %.2f rad", motion.t.norm(),
                rotationAngle(motion));
  return text;
}

class MotionPrefilter : public EntityPrefilter {
 public:
  explicit MotionPrefilter(const PrefilterParams& params)
      : params_(params), max_squared_(chiSquaredQuantile(6, params.static_probability)) {}

  FilteredPair filter(const CSceneGraph& graph, const LoopPair& pair,
                      const PoseEstimate& hypothesis) const override {
    FilteredPair filtered;
    for (const auto& [id, entity] : pairedEntities(graph, pair)) {
      if (entity.any().semantic_class == SemanticClass::kAgent &&
          params_.agents == AgentRemoval::kAlways) {
        decide(filtered, entity, true, "agent");
        continue;
      }
      const auto motion = entity.earlier && entity.later
                              ? motionBetween(*find(pair.shared, id), hypothesis)
                              : motionOfTrack(graph.tracks().at(id), entity, pair);
      decide(filtered, entity, motion.has_value(), motion ? movedText(*motion) : "static");
    }
    finish(filtered);
    return filtered;
  }

 private:
  static const SharedEntity* find(const std::vector<SharedEntity>& shared, EntityId id) {
    return &*std::find_if(shared.begin(), shared.end(),
                          [&](const SharedEntity& s) { return s.earlier.node->entity == id; });
  }

  bool exceedsThresholds(const Pose3& motion) const {
    return motion.t.norm() > params_.min_motion_m ||
           rotationAngle(motion) > params_.min_rotation_rad;
  }

  /// Eq. (6): ε_t⁻¹ ε_T beyond δ'_E and beyond the combined covariance of the two detections and
  /// of the robot's motion in between.
  std::optional<Pose3> motionBetween(const SharedEntity& shared,
                                     const PoseEstimate& earlier_later) const {
    const PoseEstimate motion = compose(compose(inverse(shared.earlier.base_entity), earlier_later),
                                        shared.later.base_entity);
    if (!exceedsThresholds(motion.T)) return std::nullopt;
    return squaredMahalanobis(motion, PoseEstimate{}) > max_squared_ ? std::optional(motion.T)
                                                                     : std::nullopt;
  }

  /// An entity that only one of the keyframes has registered: where its track says it was at the
  /// other, if the motion model noticed a displacement in between.
  std::optional<Pose3> motionOfTrack(const std::vector<std::shared_ptr<CNodeEntity>>& track,
                                     const PairedEntity& entity, const LoopPair& pair) const {
    const CNodeEntity* from = nullptr;
    const CNodeEntity* to = nullptr;
    bool displaced = false;
    for (const auto& node : track) {
      if (node->keyframe > pair.later->id) break;
      if (node->keyframe <= pair.earlier->id) {
        from = node.get();
        continue;
      }
      to = node.get();
      displaced = displaced || node->moved;
    }
    const bool known = from && to && (from == entity.earlier || to == entity.later);
    if (!known || !displaced) return std::nullopt;
    const Pose3 motion = from->T_map_entity().inverse() * to->T_map_entity();
    return exceedsThresholds(motion) ? std::optional(motion) : std::nullopt;
  }

  PrefilterParams params_;
  double max_squared_;
};

}  // namespace

std::unique_ptr<EntityPrefilter> makeMotionPrefilter(const PrefilterParams& params) {
  return std::make_unique<MotionPrefilter>(params);
}

}  // namespace dynemo
