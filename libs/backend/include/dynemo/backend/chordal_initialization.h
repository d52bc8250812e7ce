// A first estimate of a pose graph that does not depend on the poses it starts with.
#pragma once

#include <string>

#include "dynemo/core/error.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// Replaces the poses by the solution of two linear least-squares problems over the relative-pose edges: rotations
/// relaxed to 3×3 matrices and projected to SO(3), then translations (Carlone, Tron, Daniilidis and Dellaert,
/// "Initialization techniques for 3D SLAM", ICRA 2015, section IV-A). Each edge weighs with the mean variance of its
/// rotation and of its translation. In every connected part the pose with the lowest id stays where it is, of those with a prior when there are any; pose priors,
/// floors and other edges are left to the optimisation. The failure says what could not be solved; the graph is then as
/// before.
Expected<void, std::string> initializeChordal(CSceneGraph& graph);

}  // namespace dynemo
