// The newest part of the map, solved exactly while everything older stays where it is.
#pragma once

#include <span>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "front_factor.h"
#include "live_problem.h"

namespace dynemo::backend {

class WindowSolver {
 public:
  explicit WindowSolver(const SolverParams& params) : params_(params) {}

  /// Nodes from the oldest of the newest keyframes on are free, the others that their edges name
  /// are constants. Edges to constants count from `settled_edges` down only: what ties the window
  /// to the old map and is newer would bend the window towards a map that has not answered it yet.
  /// Writes the result to the graph. False when there is none (a free gauge, a cost that rises or
  /// is not finite); the graph is then as before.
  bool solve(CSceneGraph& graph, EdgeId settled_edges, OptimizationReport& report);

  /// The first node that is free.
  NodeId firstFree(const CSceneGraph& graph) const;
  /// Nodes that the last solve() wrote.
  std::span<const NodeId> written() const { return written_; }
  /// The solution of the last solve(), for marginals; empty after a failure.
  const LiveProblem& problem() const { return problem_; }
  const FrontFactor& factor() const { return factor_; }

 private:
  void collect(const CSceneGraph& graph, EdgeId settled_edges);
  bool step();

  SolverParams params_;
  CholmodContext context_;
  LiveProblem problem_;
  FrontFactor factor_;
  std::vector<EdgeId> edges_;
  std::vector<NodeId> written_;
};

}  // namespace dynemo::backend
