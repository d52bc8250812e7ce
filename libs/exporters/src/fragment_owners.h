#pragma once

#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// The entity of each point of a keyframe's scan; null where it belongs to none. The keyframe has a
/// scan.
inline std::vector<const CNodeEntity*> fragmentOwners(const CSceneGraph& graph,
                                                      const CNodeKeyframe& keyframe) {
  std::vector<const CNodeEntity*> owner(keyframe.scan->cloud.size(), nullptr);
  for (const EdgeId id : graph.edgesOf(keyframe.id)) {
    for (const NodeId node : graph.edgeSlots()[id.value]->nodes) {
      const auto* entity = graph.findNode<CNodeEntity>(node);
      if (!entity || entity->keyframe != keyframe.id) continue;
      for (const std::uint32_t i : entity->fragment) {
        if (i < owner.size()) owner[i] = entity;
      }
    }
  }
  return owner;
}

}  // namespace dynemo
