// The edges that say that an object has not moved.
#pragma once

#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo::life {

/// The edge that says that the object has not moved since an earlier observation, the first of the
/// edge's nodes; null when there is none.
const CEdgeIntraEntity* tieOf(const CSceneGraph& graph, const CNodeEntity& seen);

/// A copy of an edge whose first node is tied itself, from where the tie leads to, without an id.
/// It is as doubtful as the more doubtful of the two.
std::shared_ptr<CEdgeIntraEntity> carriedOver(const CEdgeIntraEntity& edge,
                                              const CEdgeIntraEntity& tie);

}  // namespace dynemo::life
