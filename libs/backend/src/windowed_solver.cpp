#include "windowed_solver.h"

namespace dynemo::backend {

WindowedSolver::WindowedSolver(const SolverParams& params)
    : params_(params), tiers_{Tier(params), Tier(params)} {}

WindowedSolver::~WindowedSolver() {
  if (running_.valid()) running_.wait();
}

bool WindowedSolver::join() { return !running_.valid() || running_.get(); }

void WindowedSolver::restart(const CSceneGraph& graph) {
  join();
  watch_.moved(graph);
  for (Tier& tier : tiers_) {
    tier.solver.restart(graph);
    tier.edges = graph.nextEdgeId();
    tier.moved.clear();
  }
  // The first window needs a factorisation under it: the next call makes one.
  started_ = true;
  calls_ = -1;
}

void WindowedSolver::notice(const CSceneGraph& graph) {
  for (const NodeId node : watch_.moved(graph))
    for (Tier& tier : tiers_) tier.moved.push_back(node);
}

void WindowedSolver::begin(const CSceneGraph& graph, OptimizationReport& report) {
  Tier& tier = tiers_[1 - resting_];
  tier.solver.synchronize(graph, tier.moved);
  tier.moved.clear();
  tier.edges = graph.nextEdgeId();
  // Whatever draws random numbers of the C library stays on this thread.
  tier.solver.prepare(report);
  auto work = [&solver = tier.solver] {
    OptimizationReport unused;
    return solver.solve(unused);
  };
  if (params_.second_thread) {
    running_ = std::async(std::launch::async, work);
  } else {
    std::promise<bool> done;
    done.set_value(work());
    running_ = done.get_future();
  }
  calls_ = 0;
}

void WindowedSolver::write(CSceneGraph& graph) {
  const LiveProblem& problem = resting().solver.problem();
  for (int v = 0; v < problem.variables(); ++v) {
    if (!problem.alive(v)) continue;
    const NodeId node = problem.node(v)->id;
    graph.setState(node, problem.estimate(v));
    watch_.record(*problem.node(v));
  }
  window_.reset(resting().solver, resting().edges);
}

bool WindowedSolver::merge(CSceneGraph& graph) {
  if (!join()) return false;
  resting_ = 1 - resting_;
  if (!resting().moved.empty() || !resting().solver.isPartOf(graph)) return true;
  write(graph);
  return true;
}

bool WindowedSolver::settle(CSceneGraph& graph, OptimizationReport& report) {
  Tier& tier = resting();
  tier.solver.synchronize(graph, tier.moved);
  tier.moved.clear();
  tier.edges = graph.nextEdgeId();
  report.nodes = tier.solver.nodes();
  report.edges = graph.edgeCount();
  report.tangent_size = tier.solver.tangentSize();
  if (!tier.solver.solve(report)) return false;
  write(graph);
  return true;
}

bool WindowedSolver::solve(CSceneGraph& graph, OptimizationReport& report) {
  started_ = started_ && trySolve(graph, report);
  return started_;
}

bool WindowedSolver::trySolve(CSceneGraph& graph, OptimizationReport& report) {
  const bool due = calls_ < 0 || ++calls_ >= params_.window_keyframes / 2;
  if (due) {
    notice(graph);
    if (!merge(graph)) return false;
  }
  const bool unsettled =
      calls_ < 0 || !resting().moved.empty() || !resting().solver.isPartOf(graph);
  if (unsettled && !settle(graph, report)) return false;
  if (due) begin(graph, report);
  if (unsettled) return true;
  if (!window_.solve(graph, report)) return false;
  for (const NodeId node : window_.written()) watch_.record(*graph.nodeSlots()[node.value]);
  return true;
}

bool WindowedSolver::covariance(const CSceneGraph& graph, std::span<const NodeId> nodes,
                                MatrixX& joint) {
  return started_ && calls_ >= 0 && resting().solver.isPartOf(graph) &&
         window_.covariance(graph, nodes, joint);
}

}  // namespace dynemo::backend
