// The edges of the graph as lines, for every format that draws them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// Where nodes are drawn [m, map frame], by id; a floor has no place of its own.
using NodePlaces = std::map<NodeId, Vector3>;
NodePlaces nodePlaces(const CSceneGraph& graph);

struct EdgeLine {
  Vector3 from, to;
  NodeId node_from{}, node_to{};
};

/// The line between two nodes, or nothing when neither has a place. A floor is everywhere: its end
/// is straight below the other.
std::optional<EdgeLine> lineBetween(const CSceneGraph& graph, const NodePlaces& places, NodeId a,
                                    NodeId b);

/// One edge; an edge of several nodes has a line between each two consecutive ones.
struct EdgeLines {
  EdgeId id{};
  std::vector<NodeId> nodes;
  std::vector<EdgeLine> lines;
  /// eᵀΩe, and the number of residuals that it should not exceed by much.
  double squared_error = 0.0;
  int residual_size = 0;
};

/// The edges of one kind that can be drawn, by id.
struct EdgeKindLines {
  std::string kind;
  std::uint32_t color_rgb = 0;
  std::vector<EdgeLines> edges;
};

/// In the order of edgeTypes(); kinds without edges are left out.
std::vector<EdgeKindLines> edgeLines(const CSceneGraph& graph);

/// Where a floor is drawn, seen from above: its own area, or the box around all pose nodes where it
/// has none, a little wider.
std::optional<Eigen::AlignedBox2d> floorArea(const CSceneGraph& graph, const CNodeFloor& floor);

}  // namespace dynemo
