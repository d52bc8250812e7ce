#include "dynemo/loops/without_closures.h"

#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

std::vector<Pose3> keyframesWithoutClosures(const CSceneGraph& graph, const SolverParams& solver) {
  GraphDelta copies;
  for (std::size_t i = 0; i < graph.nodeSlots().size(); ++i) {
    const auto& node = graph.nodeSlots()[i];
    // Removed nodes keep their ids: one without edges, which the optimiser leaves alone, stands in.
    copies.nodes.push_back(node ? std::dynamic_pointer_cast<CNodeBase>(node->duplicateGetSmartPtr())
                                : std::make_shared<CNodePlane>());
    copies.nodes.back()->id = {copies.nodes.size() - 1};
  }
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge || dynamic_cast<const CEdgeLoopClosure*>(edge.get())) continue;
    auto copy = std::dynamic_pointer_cast<CEdgeBase>(edge->duplicateGetSmartPtr());
    copy->id = {copies.edges.size()};
    copies.edges.push_back(std::move(copy));
  }
  CSceneGraph without;
  without.apply(copies);
  Optimizer(solver).optimize(without);
  std::vector<Pose3> poses;
  for (const auto& keyframe : without.keyframes()) poses.push_back(keyframe->T_map_base());
  return poses;
}

}  // namespace dynemo
