// The newest keyframes at once, the whole map on a second thread.
//
// Every call solves the window: what is newer than the last solution of the whole map, together
// with the nodes of the map that it touches, under what that solution knows of them. So the newest
// poses are those that a solution of everything would give, to first order, while the untouched
// part of the map waits. At fixed calls, whether the thread is done by then or not, the solution
// that was begun half a window ago is waited for and written to the graph, and the next one is
// begun. Two solvers take turns, since the window needs the factorisation of the one that rests.
#pragma once

#include <array>
#include <future>
#include <span>

#include "incremental_solver.h"
#include "state_watch.h"
#include "window_solver.h"

namespace dynemo::backend {

class WindowedSolver {
 public:
  explicit WindowedSolver(const SolverParams& params);
  ~WindowedSolver();
  WindowedSolver(const WindowedSolver&) = delete;
  WindowedSolver& operator=(const WindowedSolver&) = delete;

  /// False when a batch solution is due: at the start, and when either tier has failed.
  bool solve(CSceneGraph& graph, OptimizationReport& report);
  /// Starts from the graph as it is, which somebody else has solved; what was under way is dropped.
  void restart(const CSceneGraph& graph);

  /// Joint covariance of the nodes; false when that takes a factorisation of everything.
  bool covariance(const CSceneGraph& graph, std::span<const NodeId> nodes, MatrixX& joint);

 private:
  struct Tier {
    explicit Tier(const SolverParams& params) : solver(params) {}
    IncrementalSolver solver;
    EdgeId edges{};             ///< of the graph when it was last brought up to it
    std::vector<NodeId> moved;  ///< by others, since then
  };

  bool trySolve(CSceneGraph& graph, OptimizationReport& report);
  Tier& resting() { return tiers_[resting_]; }
  void begin(const CSceneGraph& graph, OptimizationReport& report);
  /// Waits for the solution under way; false when it failed.
  bool join();
  bool merge(CSceneGraph& graph);
  /// Brings the resting solver up to the graph, in which something of its map has gone.
  bool settle(CSceneGraph& graph, OptimizationReport& report);
  void write(CSceneGraph& graph);
  void notice(const CSceneGraph& graph);

  SolverParams params_;
  std::array<Tier, 2> tiers_;
  std::size_t resting_ = 0;
  std::future<bool> running_;
  WindowSolver window_;
  StateWatch watch_;
  bool started_ = false;
  int calls_ = 0;  ///< since the last merge
};

}  // namespace dynemo::backend
