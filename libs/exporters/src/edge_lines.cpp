#include "edge_lines.h"

#include "dynemo/graph/types.h"
#include "plane_faces.h"

namespace dynemo {

NodePlaces nodePlaces(const CSceneGraph& graph) {
  NodePlaces places;
  for (const auto& node : graph.nodeSlots()) {
    if (const auto* pose = dynamic_cast<const CNodePose*>(node.get()))
      places[pose->id] = pose->T_map_node.t;
  }
  for (const PlaneFace& face : planeFaces(graph)) places[face.plane->id] = face.middle;
  return places;
}

std::optional<EdgeLine> lineBetween(const CSceneGraph& graph, const NodePlaces& places, NodeId a,
                                    NodeId b) {
  const CNodeBase &node_a = graph.getNode<CNodeBase>(a), &node_b = graph.getNode<CNodeBase>(b);
  const auto placeOf = [&](NodeId id) {
    const auto it = places.find(id);
    return it == places.end() ? std::nullopt : std::optional(it->second);
  };
  auto p_a = placeOf(a), p_b = placeOf(b);
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
  const NodePlaces places = nodePlaces(graph);
  for (const EdgeType& type : edgeTypes()) {
    EdgeKindLines lines{type.kind, type.color_rgb, {}};
    for (const auto& edge : graph.edgeSlots()) {
      if (!edge || edge->kind() != type.kind) continue;
      EdgeLines drawn{edge->id, edge->nodes, {}, graph.squaredError(*edge), edge->residualSize()};
      for (std::size_t i = 1; i < edge->nodes.size(); ++i) {
        const auto line = lineBetween(graph, places, edge->nodes[i - 1], edge->nodes[i]);
        if (line) drawn.lines.push_back(*line);
      }
      if (!drawn.lines.empty()) lines.edges.push_back(std::move(drawn));
    }
    if (!lines.edges.empty()) kinds.push_back(std::move(lines));
  }
  return kinds;
}

std::optional<Eigen::AlignedBox2d> floorArea(const CSceneGraph& graph, const CNodeFloor& floor) {
  constexpr double kMargin_m = 1.0;
  Eigen::AlignedBox2d area = floor.area_map_m;
  for (const auto& slot : graph.nodeSlots()) {
    if (!floor.area_map_m.isEmpty()) break;
    const auto* node = dynamic_cast<const CNodePose*>(slot.get());
    if (node && node->T_map_node.isFinite()) area.extend(node->T_map_node.t.head<2>());
  }
  if (area.isEmpty()) return std::nullopt;
  const Vector2 margin = Vector2::Constant(kMargin_m);
  return Eigen::AlignedBox2d(area.min() - margin, area.max() + margin);
}

}  // namespace dynemo
