#include "window_solver.h"

#include <algorithm>
#include <cmath>

#include "stopwatch.h"

namespace dynemo::backend {
namespace {

constexpr int kMaxSteps = 3;
/// Difference between cost and model, relative to the cost, that asks for another step.
constexpr double kNonlinearity = 1e-3;
constexpr double kCostRounding = 1e-12;

}  // namespace

NodeId WindowSolver::firstFree(const CSceneGraph& graph) const {
  const auto& keyframes = graph.keyframes();
  const auto size = static_cast<std::size_t>(params_.window_keyframes);
  if (keyframes.size() <= size) return {0};
  return keyframes[keyframes.size() - size]->id;
}

void WindowSolver::collect(const CSceneGraph& graph, EdgeId settled_edges) {
  problem_ = LiveProblem();
  edges_.clear();
  const NodeId first = firstFree(graph);
  for (std::size_t i = first.value; i < graph.nodeSlots().size(); ++i) {
    if (!graph.nodeSlots()[i]) continue;
    const auto& of_node = graph.edgesOf({i});
    edges_.insert(edges_.end(), of_node.begin(), of_node.end());
  }
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  for (const EdgeId id : edges_) {
    const auto& edge = graph.edgeSlots()[id.value];
    const auto is_old = [&](NodeId node) { return node < first; };
    const bool bound = std::any_of(edge->nodes.begin(), edge->nodes.end(), is_old);
    if (bound && !(id < settled_edges)) continue;
    for (const NodeId node : edge->nodes) {
      if (problem_.variableOf(node) < 0)
        problem_.addVariable(graph.nodeSlots()[node.value], nullptr, is_old(node));
    }
    problem_.addFactor(edge);
  }
}

bool WindowSolver::step() {
  if (factor_.factorize(problem_)) return false;
  for (const int v : factor_.solve(problem_, 0.0)) problem_.updateEstimate(v);
  for (int f = 0; f < problem_.factors(); ++f) problem_.updateCost(f);
  return true;
}

bool WindowSolver::solve(CSceneGraph& graph, EdgeId settled_edges, OptimizationReport& report) {
  const SingleThreadedBlas single_threaded;
  written_.clear();
  {
    const ScopedTimer timer(report.ordering_ms);
    collect(graph, settled_edges);
    factor_.build(problem_, context_);
  }
  const ScopedTimer timer(report.numeric_ms);
  for (int f = 0; f < problem_.factors(); ++f) problem_.updateCost(f);
  report.cost_before = report.cost_after = problem_.cost();
  report.nodes = static_cast<std::size_t>(problem_.variables());
  report.edges = static_cast<std::size_t>(problem_.factors());
  report.tangent_size = static_cast<std::size_t>(problem_.tangentSize());
  for (int i = 0; i < kMaxSteps && std::isfinite(report.cost_before); ++i) {
    if (i > 0) {
      for (int v = 0; v < problem_.variables(); ++v) problem_.relinearize(v);
      for (int f = 0; f < problem_.factors(); ++f) factor_.tree().touchFactor(problem_, f);
    }
    if (!step()) break;
    ++report.iterations;
    ++report.factorizations;
    report.cost_after = problem_.cost();
    const double model = problem_.linearizedCost() - factor_.modelDecrease();
    if (!(std::abs(report.cost_after - model) > kNonlinearity * report.cost_after)) break;
  }
  const bool good = report.iterations > 0 &&
                    report.cost_after <= report.cost_before * (1.0 + kCostRounding) + kCostRounding;
  if (!good) {
    problem_ = LiveProblem();
    return false;
  }
  for (int v = 0; v < problem_.variables(); ++v) {
    if (problem_.tangentSize(v) == 0) continue;
    written_.push_back(problem_.node(v)->id);
    graph.setState(written_.back(), problem_.estimate(v));
  }
  report.stop = StopReason::kConverged;
  return true;
}

}  // namespace dynemo::backend
