#include "connection.h"

#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo::life {

bool isConnected(const CSceneGraph& graph, NodeId from, NodeId to, const std::set<NodeId>& without,
                 std::span<const std::pair<NodeId, NodeId>> more) {
  std::set<NodeId> reached = without;
  std::vector<NodeId> open;
  const auto reach = [&](NodeId node) {
    if (reached.insert(node).second) open.push_back(node);
  };
  reach(from);
  while (!open.empty() && !reached.contains(to)) {
    const NodeId node = open.back();
    open.pop_back();
    for (const auto& [a, b] : more) {
      if (a == node) reach(b);
      if (b == node) reach(a);
    }
    for (const EdgeId id : graph.edgesOf(node)) {
      const auto* edge = dynamic_cast<const CEdgeRelativePose*>(graph.edgeSlots()[id.value].get());
      if (!edge) continue;
      for (const NodeId other : edge->nodes) reach(other);
    }
  }
  return reached.contains(to);
}

}  // namespace dynemo::life
