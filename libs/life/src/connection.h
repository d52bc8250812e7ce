// Whether poses hold each other.
#pragma once

#include <set>
#include <span>
#include <utility>

#include "dynemo/graph/scene_graph.h"

namespace dynemo::life {

/// Whether a chain of relative poses leads from one node to another, through the graph without some
/// of its nodes but with some more pairs.
bool isConnected(const CSceneGraph& graph, NodeId from, NodeId to, const std::set<NodeId>& without,
                 std::span<const std::pair<NodeId, NodeId>> more);

}  // namespace dynemo::life
