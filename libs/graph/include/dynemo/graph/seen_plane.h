#pragma once

#include <optional>

#include "dynemo/graph/plane_patch.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// All that the keyframes saw of a plane, on the plane's present estimate in the map frame.
PlanePatch seenPatch(const CSceneGraph& graph, const CNodePlane& plane);

/// The storey of a plane: that of most of the keyframes that saw it, empty when none is on a floor.
std::optional<NodeId> floorOf(const CSceneGraph& graph, const CNodePlane& plane);

/// Mean of the cells' middles; the center of an empty patch.
Vector3 middleOf(const PlanePatch& patch);

}  // namespace dynemo
