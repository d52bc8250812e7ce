// How a keyframe leaves the graph.
#pragma once

#include "dynemo/graph/scene_graph.h"
#include "dynemo/life/life_params.h"

namespace dynemo {

/// Takes out a keyframe and the observations of entities made from it. What they say of the nodes
/// around them, at the present estimates and with the weights of their robust kernels there, goes
/// into edges between pairs of those: a tree of the pairs that share the most information, pairs
/// that have such an edge already, and the best of the others. Together they come as near to what
/// they replace as pairs can (M. Mazuran, W. Burgard and G. D. Tipaldi, "Nonlinear factor recovery
/// for long-term SLAM", IJRR 2016). All are relative, so that loops may still bend the map.
///
/// The keyframes before and after it stay tied by odometry as long as that says something, they are
/// neighbours, or it is all that holds them together; over half a lap it says nothing, and would
/// tie places to each other that have nothing to do with one another. No node is left without an
/// edge. Edges between observations of an agent are dropped. Throws std::logic_error for a keyframe
/// that has a prior, and std::out_of_range when there is none of that id.
GraphDelta removalOf(const CSceneGraph& graph, NodeId keyframe, const LifeParams& params);

}  // namespace dynemo
