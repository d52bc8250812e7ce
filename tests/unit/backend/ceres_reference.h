// The same problem for Ceres, written independently: residuals by automatic differentiation over
// quaternions, its own loss functions, its own solver.
#pragma once

#include "dynemo/graph/scene_graph.h"

namespace dynemo::test {

struct CeresResult {
  double cost_before = 0.0, cost_after = 0.0;
  bool converged = false;
  double seconds = 0.0;  ///< of the processor, in the solver
  int iterations = 0;
};

/// Minimises the graph's cost from its estimates, which stay as they are. The tolerance is on the
/// relative decrease.
CeresResult solveWithCeres(const CSceneGraph& graph, double tolerance);

}  // namespace dynemo::test
