#include "edge_lines.h"

#include "dynemo/graph/types.h"

namespace dynemo {

std::optional<Vector3> placeOf(const CNodeBase& node) {
  if (const auto* pose = dynamic_cast<const CNodePose*>(&node)) return pose->T_map_node.t;
  return std::nullopt;
}

std::optional<EdgeLine> lineBetween(const CSceneGraph& graph, NodeId a, NodeId b) {
  const CNodeBase &node_a = graph.getNode<CNodeBase>(a), &node_b = graph.getNode<CNodeBase>(b);
  auto p_a = placeOf(node_a), p_b = placeOf(node_b);
  const auto below = [](const CNodeBase& node, const Vector3& p) -> std::optional<Vector3> {
    const auto* floor = dynamic_cast<const CNodeFloor*>(&node);
    return floor ? std::optional(Vector3(p.x(), p.y(), floor->level_m)) : std::nullopt;
  };
  if (!p_a && p_b) p_a = below(node_a, *p_b);
  if (!p_b && p_a) p_b = below(node_b, *p_a);
  if (!p_a || !p_b) return std::nullopt;
  return EdgeLine{*p_a, *p_b, a, b};
}

std::vector<EdgeKindLines> edgeLines(const CSceneGraph& graph) {
  std::vector<EdgeKindLines> kinds;
  for (const EdgeType& type : edgeTypes()) {
    EdgeKindLines lines{type.kind, type.color_rgb, {}};
    for (const auto& edge : graph.edgeSlots()) {
      if (!edge || edge->kind() != type.kind) continue;
      EdgeLines drawn{edge->id, edge->nodes, {}, graph.squaredError(*edge), edge->residualSize()};
      for (std::size_t i = 1; i < edge->nodes.size(); ++i) {
        const auto line = lineBetween(graph, edge->nodes[i - 1], edge->nodes[i]);
        if (line) drawn.lines.push_back(*line);
      }
      if (!drawn.lines.empty()) lines.edges.push_back(std::move(drawn));
    }
    if (!lines.edges.empty()) kinds.push_back(std::move(lines));
  }
  return kinds;
}

std::optional<Eigen::AlignedBox2d> footprint(const CSceneGraph& graph) {
  Eigen::AlignedBox2d area;
  for (const auto& slot : graph.nodeSlots()) {
    const auto* node = dynamic_cast<const CNodePose*>(slot.get());
    if (node && node->T_map_node.isFinite()) area.extend(node->T_map_node.t.head<2>());
  }
  return area.isEmpty() ? std::nullopt : std::optional(area);
}

}  // namespace dynemo
