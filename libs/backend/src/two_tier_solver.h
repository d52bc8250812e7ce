// The newest poses at once, the whole map on a second thread.
//
// Every call solves the window of the newest keyframes. Every `join_every` calls the solution of
// the whole map that was begun at the last such call is waited for and merged, and the next one is
// begun with what has come since: so the result does not depend on how fast either thread is. What
// is newer than the merged solution moves along rigidly with the keyframe at its end, so that the
// robot's surroundings stay as they are.
#pragma once

#include <future>
#include <span>

#include "incremental_solver.h"
#include "state_watch.h"
#include "window_solver.h"

namespace dynemo::backend {

class TwoTierSolver {
 public:
  explicit TwoTierSolver(const SolverParams& params)
      : params_(params), whole_(params), window_(params) {}
  ~TwoTierSolver() { wait(); }
  TwoTierSolver(const TwoTierSolver&) = delete;
  TwoTierSolver& operator=(const TwoTierSolver&) = delete;

  /// False when a batch solution is due: at the start, and when either tier has failed.
  bool solve(CSceneGraph& graph, OptimizationReport& report);
  /// Forgets the solution under way; for when the graph has been solved in batch.
  void restart(const CSceneGraph& graph);

  /// Whether the window's last solution holds all of the nodes, as free ones where they still are.
  bool windowKnows(const CSceneGraph& graph, std::span<const NodeId> nodes) const;
  const WindowSolver& window() const { return window_; }

 private:
  void wait();
  void begin();
  bool join(CSceneGraph& graph, OptimizationReport& report);
  void merge(CSceneGraph& graph, std::span<const NodeId> moved);
  void write(CSceneGraph& graph, NodeId node, const double* state);

  SolverParams params_;
  IncrementalSolver whole_;
  WindowSolver window_;
  StateWatch watch_;
  std::future<bool> running_;
  bool started_ = false;
  int calls_ = 0;
  /// Nodes and edges of the solution under way, and edges of the one that was merged last.
  NodeId begun_nodes_{};
  EdgeId begun_edges_{}, merged_edges_{};
  NodeId anchor_{};
  std::vector<char> stale_;  ///< per node: the window wrote it since the last merge
};

}  // namespace dynemo::backend
