// Which keyframes the graph can do without.
#pragma once

#include <vector>

#include "dynemo/graph/scene_graph.h"
#include "dynemo/life/life_params.h"

namespace dynemo {

/// Older keyframes than the window's, where a square of the floor and a heading hold more than they
/// should: the newest of them, so that a map that is complete stays as it is, and once they are
/// enough for a batch. Ascending by id.
///
/// Never among them: the first keyframe, the first of each floor, keyframes with a prior, and those
/// that hold the history of the entities: the first and the last observation of each, and of
/// objects every one at the end of a stay and at the beginning of the next.
std::vector<NodeId> surplusKeyframes(const CSceneGraph& graph, const LifeParams& params);

}  // namespace dynemo
