#include <mrpt/opengl/CGridPlaneXY.h>
#include <mrpt/opengl/CSetOfLines.h>

#include <map>
#include <optional>
#include <utility>

#include "dynemo/graph/types.h"
#include "scene_style.h"

namespace dynemo {
namespace {

/// The ends of the line between two nodes, or nothing when neither has a place. A floor is
/// everywhere: its end is straight below the other.
std::optional<std::pair<Vector3, Vector3>> lineBetween(const CSceneGraph& graph, NodeId a,
                                                       NodeId b) {
  const auto* pose_a = graph.findNode<CNodePose>(a);
  const auto* pose_b = graph.findNode<CNodePose>(b);
  if (pose_a && pose_b) return std::pair(pose_a->T_map_node.t, pose_b->T_map_node.t);
  const CNodePose* pose = pose_a ? pose_a : pose_b;
  const auto* floor = graph.findNode<CNodeFloor>(pose_a ? b : a);
  if (!pose || !floor) return std::nullopt;
  const Vector3& p = pose->T_map_node.t;
  return std::pair(Vector3(p.x(), p.y(), floor->level_m), p);
}

/// Corners of the box around all keyframes and entities, seen from above.
std::optional<Eigen::AlignedBox2d> footprint(const CSceneGraph& graph) {
  Eigen::AlignedBox2d area;
  for (const auto& slot : graph.nodeSlots()) {
    const auto* node = dynamic_cast<const CNodePose*>(slot.get());
    if (node && node->T_map_node.isFinite()) area.extend(node->T_map_node.t.head<2>());
  }
  return area.isEmpty() ? std::nullopt : std::optional(area);
}

}  // namespace

mrpt::opengl::CSetOfObjects::Ptr sceneEdges(const RunResult& run, const SceneParams& params) {
  std::map<std::string, mrpt::opengl::CSetOfLines::Ptr> by_kind;
  for (const auto& edge : run.graph.edgeSlots()) {
    if (!edge) continue;
    auto& lines = by_kind[edge->kind()];
    if (!lines) {
      lines = mrpt::opengl::CSetOfLines::Create();
      lines->setName(edge->kind());
      lines->setLineWidth(params.edge_line_px);
      lines->setColor_u8(colorFromRgb(edgeType(edge->kind()).color_rgb, 160));
    }
    for (std::size_t i = 1; i < edge->nodes.size(); ++i) {
      const auto line = lineBetween(run.graph, edge->nodes[i - 1], edge->nodes[i]);
      if (line) lines->appendLine(toPoint(line->first), toPoint(line->second));
    }
  }
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("edges");
  for (const auto& [kind, lines] : by_kind) group->insert(lines);
  return group;
}

mrpt::opengl::CSetOfObjects::Ptr sceneFloors(const RunResult& run, const SceneParams& params) {
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("floors");
  const auto area = footprint(run.graph);
  if (!area) return group;
  const Eigen::Vector2f min = (area->min().array() - params.floor_margin_m).cast<float>();
  const Eigen::Vector2f max = (area->max().array() + params.floor_margin_m).cast<float>();
  for (const auto& floor : run.graph.floors()) {
    auto grid = mrpt::opengl::CGridPlaneXY::Create(min.x(), max.x(), min.y(), max.y(),
                                                   static_cast<float>(floor->level_m), 1.0f);
    grid->setColor_u8(colorFromRgb(0xb8b8b8));
    grid->setName("floor " + std::to_string(floor->id.value));
    group->insert(grid);
  }
  return group;
}

}  // namespace dynemo
