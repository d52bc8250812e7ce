#include "dynemo/evaluation/entity_change.h"

#include <algorithm>
#include <map>

namespace dynemo {
namespace {

using Track = std::vector<const EntityNodeError*>;

/// Observations of each entity of the class in the order of time.
std::map<EntityId, Track> tracksOf(const EntityErrors& errors, SemanticClass semantic_class) {
  std::map<EntityId, Track> tracks;
  for (const EntityNodeError& node : errors.nodes) {
    if (node.estimate.semantic_class == semantic_class) {
      tracks[node.estimate.entity].push_back(&node);
    }
  }
  for (auto& [id, track] : tracks) {
    std::stable_sort(track.begin(), track.end(), [](const auto* a, const auto* b) {
      return a->estimate.stamp < b->estimate.stamp;
    });
  }
  return tracks;
}

void count(DetectionCounts& counts, bool truth, bool reported) {
  counts.true_positives += truth && reported;
  counts.false_positives += !truth && reported;
  counts.false_negatives += truth && !reported;
}

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

ObjectChange changeOf(EntityId id, const Track& track, const ChangeParams& params,
                      DetectionCounts& by_observation) {
  ObjectChange change{id, false, track.front()->estimate.moved};
  count(by_observation, false, track.front()->estimate.moved);
  for (std::size_t i = 1; i < track.size(); ++i) {
    const PoseError motion = poseError(track[i - 1]->T_world_entity, track[i]->T_world_entity);
    const bool moved = motion.translation_m > params.min_translation_m ||
                       motion.rotation_rad > params.min_rotation_rad;
    count(by_observation, moved, track[i]->estimate.moved);
    change.truly_moved |= moved;
    change.reported_moved |= track[i]->estimate.moved;
  }
  return change;
}

DetectionCounts objectsAtEnd(const std::map<EntityId, Track>& tracks, const EntityTruths& truths,
                             double max_distance_m) {
  DetectionCounts counts;
  for (const auto& [id, truth] : truths) {
    if (truth.semantic_class != SemanticClass::kObject) continue;
    const auto it = tracks.find(id);
    const Vector3& p_world = truth.poses.back().T.t;
    const bool seen = it != tracks.end();
    const bool found =
        seen && (it->second.back()->T_world_entity_estimated.t - p_world).norm() <= max_distance_m;
    counts.true_positives += found;
    counts.false_negatives += !found;
    counts.false_positives += seen && !found;
  }
  return counts;
}

}  // namespace

double DetectionCounts::precision() const {
  return ratio(true_positives, true_positives + false_positives);
}

double DetectionCounts::recall() const {
  return ratio(true_positives, true_positives + false_negatives);
}

double DetectionCounts::f1() const {
  return ratio(2 * true_positives, 2 * true_positives + false_positives + false_negatives);
}

ChangeReport evaluateChanges(const EntityErrors& errors, const EntityTruths& truths,
                             const ChangeParams& params) {
  ChangeReport report;
  const auto tracks = tracksOf(errors, SemanticClass::kObject);
  for (const auto& [id, track] : tracks) {
    report.objects.push_back(changeOf(id, track, params, report.by_observation));
    count(report.by_object, report.objects.back().truly_moved,
          report.objects.back().reported_moved);
  }
  report.objects_at_end = objectsAtEnd(tracks, truths, params.max_object_distance_m);
  return report;
}

MotionErrors evaluateMotions(const EntityErrors& errors, SemanticClass semantic_class) {
  std::vector<PoseError> me, rme;
  for (const auto& [id, track] : tracksOf(errors, semantic_class)) {
    for (std::size_t i = 1; i < track.size(); ++i) {
      const Pose3& L_before = track[i - 1]->T_world_entity;
      const Pose3& L_after = track[i]->T_world_entity;
      const Pose3 H = L_after * L_before.inverse();
      const Pose3 H_estimated =
          track[i]->T_world_entity_estimated * track[i - 1]->T_world_entity_estimated.inverse();
      me.push_back(poseError(Pose3(), H.inverse() * H_estimated));
      rme.push_back(poseError(Pose3(), L_after.inverse() * H_estimated * L_before));
    }
  }
  return {summarize(me), summarize(rme)};
}

}  // namespace dynemo
