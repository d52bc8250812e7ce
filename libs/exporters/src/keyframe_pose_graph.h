// The keyframes' pose graph with at most one edge per pair, for formats that keep no parallel
// edges.
#pragma once

#include <map>
#include <utility>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// A measured relative pose and the information of its right tangent.
struct RelativePose {
  Pose3 T_1_2;
  Matrix6 information = Matrix6::Identity();
};

/// The same measurement seen from the other side: T_2_1, with its information carried along to
/// first order.
RelativePose inverted(const RelativePose& edge);

/// Both measurements of one relative pose in one: the information adds up, the mean is its weighted
/// mean (one Gauss–Newton step from a's mean).
RelativePose fused(const RelativePose& a, const RelativePose& b);

/// By keyframe pair, in the direction of the pair's first edge. Parallel and opposed edges are
/// fused.
std::map<std::pair<NodeId, NodeId>, RelativePose> keyframePoseGraph(const CSceneGraph& graph);

}  // namespace dynemo
