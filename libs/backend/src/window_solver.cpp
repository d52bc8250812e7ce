#include "window_solver.h"

#include <algorithm>
#include <cmath>

#include "front_marginals.h"
#include "stopwatch.h"

namespace dynemo::backend {
namespace {

constexpr int kMaxSteps = 5;
/// Difference between cost and model, relative to the cost, that asks for another step.
constexpr double kNonlinearity = 3e-4;
constexpr double kCostRounding = 1e-9;
/// Nothing is carried on to the rest of the map before it lowers the cost by this share of the
/// map's.
constexpr double kCarriedCost = 7e-4;
/// Nor are the smallest steps that cost up to this share together.
constexpr double kNeglectedCost = 3e-4;
/// The limit of those [m, rad], by how much it is adjusted, and at which part of that cost it is
/// raised.
constexpr double kLeastCarried = 1e-6, kMostCarried = 5e-3;
constexpr double kAdjustment = 1.5, kLittleNeglected = 0.2;
/// What is left undone below nodes that stand still a lower limit does not reach.
constexpr int kMostRounds = 3;

}  // namespace

void WindowSolver::reset(const IncrementalSolver& map, EdgeId edges) {
  prior_.reset(map);
  follower_.reset(map);
  map_cost_ = map.problem().cost();
  begin_ = end_ = edges;
  problem_ = LiveProblem();
  touched_states_.clear();
  offset_.resize(0);
  carried_.resize(0);
  written_.clear();
}

bool WindowSolver::takeEdges(const CSceneGraph& graph) {
  const LiveProblem& map = prior_.map().problem();
  for (std::size_t i = end_.value; i < graph.edgeSlots().size(); ++i) {
    if (!graph.edgeSlots()[i]) continue;
    for (const NodeId node : graph.edgeSlots()[i]->nodes) {
      const int v = map.variableOf(node);
      if (v < 0) continue;
      const std::size_t before = prior_.nodes().size();
      if (!prior_.touch(node)) return false;
      if (prior_.nodes().size() == before) continue;
      touched_states_.emplace_back(map.estimate(v), map.estimate(v) + map.node(v)->stateSize());
      offset_.conservativeResizeLike(VectorX::Zero(prior_.size()));
      carried_.conservativeResize(prior_.size());
      std::copy_n(follower_.step(v), map.tangentSize(v), carried_.end() - map.tangentSize(v));
    }
  }
  end_ = graph.nextEdgeId();
  return true;
}

bool WindowSolver::collect(const CSceneGraph& graph) {
  if (!takeEdges(graph)) return false;
  edge_count_ = graph.edgeCount();
  problem_ = LiveProblem();
  // The touched nodes come first: their tangents are those of the prior, in its order.
  for (std::size_t i = 0; i < prior_.nodes().size(); ++i)
    problem_.addVariable(graph.nodeSlots()[prior_.nodes()[i].value], touched_states_[i].data());
  for (std::size_t i = begin_.value; i < graph.edgeSlots().size(); ++i) {
    const auto& edge = graph.edgeSlots()[i];
    if (!edge) continue;
    for (const NodeId node : edge->nodes) {
      if (problem_.variableOf(node) < 0) problem_.addVariable(graph.nodeSlots()[node.value]);
    }
    problem_.addFactor(edge);
  }
  factor_.tree().setClique(static_cast<int>(prior_.nodes().size()));
  factor_.build(problem_, context_);
  return true;
}

bool WindowSolver::factorize() {
  const VectorX gradient = prior_.information() * offset_;
  return !factor_.factorize(problem_, {&prior_.information(), &gradient});
}

double WindowSolver::priorCost(const VectorX& offset) const {
  return 0.5 * offset.dot(prior_.information() * offset);
}

double WindowSolver::cost() const {
  const Eigen::Map<const VectorX> delta(problem_.delta(0), prior_.size());
  return problem_.cost() + priorCost(offset_ + delta);
}

void WindowSolver::step() {
  for (const int v : factor_.solve(problem_, 0.0)) problem_.updateEstimate(v);
  problem_.updateCosts();
}

bool WindowSolver::iterate(OptimizationReport& report) {
  for (int i = 0; i < kMaxSteps; ++i) {
    if (i > 0) {
      offset_ += Eigen::Map<const VectorX>(problem_.delta(0), prior_.size());
      for (int v = 0; v < problem_.variables(); ++v) problem_.relinearize(v);
      for (int f = 0; f < problem_.factors(); ++f) factor_.tree().touchFactor(problem_, f);
    }
    {
      const PhaseTimer timer(report.numeric_ms);
      if (!factorize()) return false;
    }
    ++report.factorizations;
    const PhaseTimer timer(report.solve_ms);
    const double start = problem_.linearizedCost() + priorCost(offset_);
    if (i == 0) report.cost_before = start;
    step();
    ++report.iterations;
    report.cost_after = cost();
    if (!std::isfinite(report.cost_after)) return false;
    const double model = start - factor_.modelDecrease();
    if (std::abs(report.cost_after - model) <= kNonlinearity * report.cost_after) break;
  }
  return report.cost_after <= report.cost_before * (1.0 + kCostRounding) + kCostRounding;
}

bool WindowSolver::solve(CSceneGraph& graph, OptimizationReport& report) {
  written_.clear();
  {
    const PhaseTimer timer(report.ordering_ms);
    if (!collect(graph)) return false;
  }
  report.nodes = static_cast<std::size_t>(problem_.variables());
  report.edges = static_cast<std::size_t>(problem_.factors());
  report.tangent_size = static_cast<std::size_t>(problem_.tangentSize());
  if (report.edges == 0) {
    report.stop = StopReason::kNothingToDo;
    return true;
  }
  if (!iterate(report)) return false;
  const PhaseTimer timer(report.solve_ms);
  write(graph);
  carryOn(graph);
  report.stop = StopReason::kConverged;
  return true;
}

void WindowSolver::write(CSceneGraph& graph) {
  offset_ += Eigen::Map<const VectorX>(problem_.delta(0), prior_.size());
  for (int v = 0; v < problem_.variables(); ++v) {
    const std::size_t size = static_cast<std::size_t>(problem_.node(v)->stateSize());
    if (v < static_cast<int>(touched_states_.size()))
      touched_states_[static_cast<std::size_t>(v)].assign(problem_.estimate(v),
                                                          problem_.estimate(v) + size);
    written_.push_back(problem_.node(v)->id);
    graph.setState(written_.back(), problem_.estimate(v));
  }
}

bool WindowSolver::isBehind() const {
  const VectorX d = offset_ - carried_;
  const double excess =
      0.5 * (d.dot(prior_.heldInformation() * d) - d.dot(prior_.information() * d));
  return excess > kCarriedCost * map_cost_;
}

void WindowSolver::carryOn(CSceneGraph& graph) {
  if (!isBehind()) return;
  carried_ = offset_;
  const LiveProblem& map = prior_.map().problem();
  const VectorX weights = prior_.information() * offset_;
  for (int round = 0; round < kMostRounds; ++round) {
    for (const int v : follower_.follow(prior_.columns(), weights, carried_above_)) {
      const CNodeBase& node = *map.node(v);
      if (problem_.variableOf(node.id) >= 0) continue;
      state_.resize(static_cast<std::size_t>(node.stateSize()));
      node.retract(map.estimate(v), follower_.step(v), state_.data());
      graph.setState(node.id, state_.data());
      written_.push_back(node.id);
    }
    const double neglected = follower_.neglectedCost() / (kNeglectedCost * map_cost_);
    if (neglected < kLittleNeglected)
      carried_above_ = std::min(carried_above_ * kAdjustment, kMostCarried);
    if (!(neglected > 1.0) || carried_above_ < kLeastCarried) return;
    carried_above_ /= kAdjustment * kAdjustment;
  }
}

bool WindowSolver::covariance(const CSceneGraph& graph, std::span<const NodeId> nodes,
                              MatrixX& joint) {
  if (end_ != graph.nextEdgeId() || edge_count_ != graph.edgeCount()) {
    if (!collect(graph) || !factorize()) return false;
  }
  const LiveProblem& map = prior_.map().problem();
  // Each node's tangent as a linear function of the window's (columns), and what the window does
  // not know of it: x = Σ_xt Σ_tt⁻¹ t + rest.
  std::vector<int> begin = {0};
  for (const NodeId node : nodes) {
    const int w = problem_.variableOf(node), v = map.variableOf(node);
    if (w < 0 && v < 0) return false;
    begin.push_back(begin.back() + (w >= 0 ? problem_.tangentSize(w) : map.tangentSize(v)));
  }
  MatrixX functions = MatrixX::Zero(problem_.tangentSize(), begin.back());
  std::vector<MapPrior::Other> others(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const int w = problem_.variableOf(nodes[i]), size = begin[i + 1] - begin[i];
    if (w >= 0) {
      functions.block(problem_.tangentOffset(w), begin[i], size, size).setIdentity();
      continue;
    }
    others[i] = prior_.other(nodes[i]);
    functions.block(0, begin[i], prior_.size(), size) =
        prior_.information() * others[i].with_touched;
  }
  joint = problem_.variables() > 0 ? quadraticForm(problem_, factor_, functions)
                                   : MatrixX::Zero(begin.back(), begin.back());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      if (others[i].columns.fronts.empty() || others[j].columns.fronts.empty()) continue;
      joint.block(begin[i], begin[j], begin[i + 1] - begin[i], begin[j + 1] - begin[j]) +=
          backend::covariance(others[i].columns, others[j].columns) -
          others[i].with_touched.transpose() *
              functions.block(0, begin[j], prior_.size(), begin[j + 1] - begin[j]);
    }
  }
  return true;
}

}  // namespace dynemo::backend
