// The entities that two keyframes see, and what they say about the pose between the two.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "dynemo/graph/scene_graph.h"
#include "dynemo/loops/loop_params.h"
#include "dynemo/loops/pose_estimate.h"

namespace dynemo {

/// One entity as a keyframe saw it.
struct EntityView {
  const CNodeEntity* node = nullptr;
  /// Detected T_base_entity.
  PoseEstimate base_entity;
};

/// The entities registered to a keyframe, in the order of their ids. Of several sensors' detections
/// the most certain one counts.
std::map<EntityId, EntityView> entitiesSeenFrom(const CSceneGraph& graph,
                                                const CNodeKeyframe& keyframe);

/// An entity registered to both keyframes of a pair.
struct SharedEntity {
  EntityView earlier, later;
  /// T_earlier_later, if the entity did not move in between.
  PoseEstimate earlier_later;
};

std::vector<SharedEntity> sharedEntities(const CSceneGraph& graph, const CNodeKeyframe& earlier,
                                         const CNodeKeyframe& later);

/// What most objects agree on.
struct EntityConsensus {
  PoseEstimate earlier_later;
  std::vector<EntityId> members;  ///< ascending
};

/// The relative pose that the largest number of shared objects agree on within their covariances:
/// objects that share one rigid displacement. Agents have no say. Empty when fewer than
/// params.min_shared agree.
std::optional<EntityConsensus> findConsensus(const std::vector<SharedEntity>& shared,
                                             const EntityEvidenceParams& params);

}  // namespace dynemo
