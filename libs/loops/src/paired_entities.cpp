#include <algorithm>

#include "prefilters.h"

namespace dynemo {

std::map<EntityId, PairedEntity> pairedEntities(const CSceneGraph& graph, const LoopPair& pair) {
  std::map<EntityId, PairedEntity> entities;
  for (const auto& [id, view] : entitiesSeenFrom(graph, *pair.earlier))
    entities[id].earlier = view.node;
  for (const auto& [id, view] : entitiesSeenFrom(graph, *pair.later))
    entities[id].later = view.node;
  return entities;
}

namespace {

std::size_t take(const CNodeEntity* node, bool remove, PointIndices& removed) {
  if (!node) return 0;
  if (remove) removed.insert(removed.end(), node->fragment.begin(), node->fragment.end());
  return node->fragment.size();
}

void sortUnique(PointIndices& indices) {
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}

}  // namespace

void decide(FilteredPair& filtered, const PairedEntity& entity, bool remove,
            const std::string& reason) {
  EntityDecision decision;
  decision.entity = entity.any().entity;
  decision.removed = remove;
  decision.reason = reason;
  decision.points_earlier = take(entity.earlier, remove, filtered.removed_earlier);
  decision.points_later = take(entity.later, remove, filtered.removed_later);
  filtered.entities.push_back(std::move(decision));
}

void finish(FilteredPair& filtered) {
  sortUnique(filtered.removed_earlier);
  sortUnique(filtered.removed_later);
}

}  // namespace dynemo
