// The pose graph within a scene graph, for MRPT's optimiser.
#pragma once

#include "dynemo/graph/scene_graph.h"

namespace dynemo::test {

struct MrptResult {
  double seconds = 0.0;  ///< of the processor, in the optimiser
  int iterations = 0;
  /// Of the graph, of which MRPT takes this share: it knows neither priors, planes, floors and
  /// agents' motion nor robust kernels.
  double edges_share = 0.0;
};

/// From the graph's estimates, which stay as they are, until no step is longer than
/// `min_relative_step` of the state. The first pose is held.
MrptResult solveWithMrpt(const CSceneGraph& graph, double min_relative_step);

}  // namespace dynemo::test
