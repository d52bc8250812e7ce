#pragma once

#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// T_map_base of every keyframe as the same graph has it without its loop closures, optimised
/// afresh: what the closures have done.
std::vector<Pose3> keyframesWithoutClosures(const CSceneGraph& graph, const SolverParams& solver);

}  // namespace dynemo
