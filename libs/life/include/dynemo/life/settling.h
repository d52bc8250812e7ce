// Old observations of objects that have not moved, tied to where these were put down.
#pragma once

#include "dynemo/graph/scene_graph.h"
#include "dynemo/life/life_params.h"

namespace dynemo {

/// Observations that are older than the window, and tied to an earlier one of the same object by
/// its not having moved, are tied to the first of its stay instead, as firmly as they were: an
/// unmoved object is where it was. The observations of a stay are then around one node. In a chain
/// by time, which goes back and forth between visits, every part of the floor hangs on every other.
GraphDelta settledTies(const CSceneGraph& graph, const LifeParams& params);

}  // namespace dynemo
