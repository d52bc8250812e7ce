#include "dynemo/loops/shared_entities.h"

#include <algorithm>

#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

std::map<EntityId, EntityView> entitiesSeenFrom(const CSceneGraph& graph,
                                                const CNodeKeyframe& keyframe) {
  std::map<EntityId, EntityView> views;
  for (const EdgeId id : graph.edgesOf(keyframe.id)) {
    const auto* edge = dynamic_cast<const CEdgeKeyframeEntity*>(graph.edgeSlots()[id.value].get());
    if (!edge) continue;
    const auto* node = graph.findNode<CNodeEntity>(edge->nodes[1]);
    const auto covariance = invertSpd(MatrixX(edge->information()));
    if (!node || node->keyframe != keyframe.id || !covariance) continue;
    const EntityView view{node, {edge->T_1_2, Matrix6(*covariance)}};
    const auto [at, first] = views.emplace(node->entity, view);
    if (!first && view.base_entity.covariance.trace() < at->second.base_entity.covariance.trace())
      at->second = view;
  }
  return views;
}

std::vector<SharedEntity> sharedEntities(const CSceneGraph& graph, const CNodeKeyframe& earlier,
                                         const CNodeKeyframe& later) {
  std::vector<SharedEntity> shared;
  const auto seen_later = entitiesSeenFrom(graph, later);
  if (seen_later.empty()) return shared;
  for (const auto& [entity, view] : entitiesSeenFrom(graph, earlier)) {
    const auto it = seen_later.find(entity);
    if (it == seen_later.end()) continue;
    shared.push_back(
        {view, it->second, compose(view.base_entity, inverse(it->second.base_entity))});
  }
  return shared;
}

namespace {

bool isObject(const SharedEntity& s) {
  return s.earlier.node->semantic_class == SemanticClass::kObject;
}

/// The objects that agree with one of them.
std::vector<const SharedEntity*> agreeingWith(const SharedEntity& one,
                                              const std::vector<SharedEntity>& shared,
                                              double max_squared) {
  std::vector<const SharedEntity*> members;
  for (const SharedEntity& other : shared) {
    if (!isObject(other)) continue;
    if (&other == &one || squaredMahalanobis(one.earlier_later, other.earlier_later) <= max_squared)
      members.push_back(&other);
  }
  return members;
}

}  // namespace

std::optional<EntityConsensus> findConsensus(const std::vector<SharedEntity>& shared,
                                             const EntityEvidenceParams& params) {
  const double max_squared = chiSquaredQuantile(6, params.consensus_probability);
  std::vector<const SharedEntity*> best;
  double best_spread = 0.0;
  for (const SharedEntity& one : shared) {
    if (!isObject(one)) continue;
    auto members = agreeingWith(one, shared, max_squared);
    double spread = 0.0;
    for (const SharedEntity* member : members) {
      if (member != &one) spread += squaredMahalanobis(one.earlier_later, member->earlier_later);
    }
    const bool better =
        members.size() > best.size() || (members.size() == best.size() && spread < best_spread);
    if (!better) continue;
    best = std::move(members);
    best_spread = spread;
  }
  if (best.empty() || best.size() < static_cast<std::size_t>(params.min_shared))
    return std::nullopt;

  std::vector<PoseEstimate> estimates;
  EntityConsensus consensus;
  for (const SharedEntity* member : best) {
    estimates.push_back(member->earlier_later);
    consensus.members.push_back(member->earlier.node->entity);
  }
  const auto fused = fuse(estimates);
  if (!fused) return std::nullopt;
  consensus.earlier_later = *fused;
  return consensus;
}

}  // namespace dynemo
