// Edges that take the place of those of keyframes that leave.
#pragma once

#include <optional>
#include <set>
#include <span>

#include "dynemo/core/noise.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo::life {

/// What is to leave, and what hangs on it.
struct Departure {
  NodeId keyframe{};
  /// Keyframes before and after it in time, where odometry ties it to both.
  std::optional<NodeId> before, after;
  /// The keyframe first, then the observations made from it.
  std::vector<NodeId> nodes;
  /// Edges of the nodes: those that are used up, and those that are dropped.
  std::vector<EdgeId> factors, dropped;
  /// Edges between an unmoved object's leaving observation and others than the one before it, to
  /// which they go over.
  std::vector<std::pair<EdgeId, CEdgeBase::Ptr>> rehung;
};

/// An edge between two nodes whose residual at the present estimates is zero, of the kind that the
/// graph has for the two, without an id or an information matrix; null where it has none.
CEdgeBase::Ptr edgeBetween(const CSceneGraph& graph, const Departure& departure, const CNodeBase& a,
                           const CNodeBase& b);

/// The edge of the same kind between the same nodes, of those that have no kernel, or null.
const CEdgeBase* sameEdge(const CSceneGraph& graph, const CEdgeBase& edge);

/// Lets a new edge to a plane measure it at the point, and of the part, that another one does.
void measureLike(const CEdgeBase& other, CEdgeBase& edge);

/// Moves what an edge measures, so that its residual at the present estimates becomes −d: `d` is
/// where it lies from them.
void shiftMeasurement(CEdgeBase& edge, const VectorX& d);

/// Gives an edge to a plane the part of it that the leaving keyframe saw.
void takeSight(const CSceneGraph& graph, const Departure& departure, CEdgeBase& edge);

}  // namespace dynemo::life
