#include "dynemo/life/settling.h"

#include "object_tie.h"

namespace dynemo {
namespace {

using namespace life;
using Track = std::vector<std::shared_ptr<CNodeEntity>>;

void settle(const CSceneGraph& graph, const Track& track, NodeId window, GraphDelta& delta) {
  // As they will be, by observation.
  std::map<NodeId, std::shared_ptr<const CEdgeIntraEntity>> settled;
  for (const auto& seen : track) {
    if (seen->keyframe >= window) return;
    const CEdgeIntraEntity* tie = tieOf(graph, *seen);
    if (!tie) continue;
    const auto there = settled.find(tie->nodes[0]);
    const CEdgeIntraEntity* onwards = there != settled.end()
                                          ? there->second.get()
                                          : tieOf(graph, graph.getNode<CNodeEntity>(tie->nodes[0]));
    if (!onwards) continue;
    const auto edge = carriedOver(*tie, *onwards);
    edge->id = {graph.nextEdgeId().value + delta.edges.size()};
    delta.removed_edges.push_back(tie->id);
    delta.edges.push_back(edge);
    settled.emplace(seen->id, edge);
  }
}

}  // namespace

GraphDelta settledTies(const CSceneGraph& graph, const LifeParams& params) {
  GraphDelta delta;
  const auto window = static_cast<std::size_t>(params.window);
  if (graph.keyframes().size() <= window) return delta;
  const NodeId newer = graph.keyframes()[graph.keyframes().size() - window]->id;
  for (const auto& [entity, track] : graph.tracks()) settle(graph, track, newer, delta);
  return delta;
}

}  // namespace dynemo
