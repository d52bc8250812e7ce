#include "object_tie.h"

#include <algorithm>

namespace dynemo::life {

const CEdgeIntraEntity* tieOf(const CSceneGraph& graph, const CNodeEntity& seen) {
  if (seen.semantic_class == SemanticClass::kAgent || seen.moved) return nullptr;
  for (const EdgeId id : graph.edgesOf(seen.id)) {
    const auto* edge = dynamic_cast<const CEdgeIntraEntity*>(graph.edgeSlots()[id.value].get());
    if (edge && edge->nodes[1] == seen.id && edge->nodes[0] < seen.id &&
        local(Pose3(), edge->T_1_2).isZero())
      return edge;
  }
  return nullptr;
}

std::shared_ptr<CEdgeIntraEntity> carriedOver(const CEdgeIntraEntity& edge,
                                              const CEdgeIntraEntity& tie) {
  auto copy = std::dynamic_pointer_cast<CEdgeIntraEntity>(edge.duplicateGetSmartPtr());
  std::replace(copy->nodes.begin(), copy->nodes.end(), tie.nodes[1], tie.nodes[0]);
  // What is perhaps a small motion has a kernel that gives way.
  if (tie.kernel.type == KernelType::kCauchy) copy->kernel = tie.kernel;
  return copy;
}

}  // namespace dynemo::life
