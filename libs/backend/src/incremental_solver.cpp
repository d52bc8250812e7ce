#include "incremental_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "cholmod_context.h"
#include "stopwatch.h"

namespace dynemo::backend {
namespace {

/// Share of new variables from which a fresh order is better than an extended one.
constexpr double kRenewalGrowth = 0.25;
/// The price of a renewal besides the factorisation, in flops to every variable: ordering, symbolic
/// analysis and a linearisation of everything; ordering many takes more.
constexpr double kRenewalPriceOfFew = 1e5, kRenewalPriceOfMany = 5e5;
constexpr int kMany = 1000;
/// Steps over which the present price of one is averaged.
constexpr std::size_t kWorkWindow = 5;
/// Difference between cost and model, relative to the cost, that asks for another step.
constexpr double kNonlinearity = 5e-5;
/// Predicted decrease of the cost by which another step is worth its while.
constexpr double kWorthwhile = 5e-5;
/// Relative rounding error of the sum of squares.
constexpr double kCostRounding = 1e-12;
/// More steps than this are better taken with damping.
constexpr int kMaxSteps = 8;
/// Corrections that do not leave less than this share of the mismatch give way to linearisations.
constexpr double kSlowContraction = 0.5;
/// Steps after the first evaluate anew what has moved by this fraction of the usual distance.
constexpr double kTighterRelinearization = 0.1;

void mark(std::vector<char>& is, std::vector<int>& list, int i) {
  if (static_cast<std::size_t>(i) >= is.size()) is.resize(static_cast<std::size_t>(i) + 1, 0);
  if (is[i]) return;
  is[i] = 1;
  list.push_back(i);
}

void unmark(std::vector<char>& is, std::vector<int>& list) {
  for (const int i : list) is[i] = 0;
  list.clear();
}

}  // namespace

void IncrementalSolver::reset() {
  problem_ = LiveProblem();
  known_edges_ = 0;
  unmark(is_pending_, pending_);
  unmark(is_stale_, stale_);
  unmark(is_correction_, corrections_);
  unmark(is_changed_, changed_);
  unmark(is_cost_, costs_);
  new_.clear();
  drift_.clear();
  insists_ = false;
  needs_build_ = true;
  mostly_new_ = false;
}

void IncrementalSolver::restart(const CSceneGraph& graph) {
  reset();
  synchronize(graph, {});
  mostly_new_ = false;
}

void IncrementalSolver::forgetMissing(const CSceneGraph& graph) {
  const int newest = newestFactor();
  if (newest >= 0 && isPartOf(graph)) return;
  if (newest < 0) known_edges_ = 0;
  for (int v = 0; v < problem_.variables(); ++v) {
    if (!problem_.alive(v)) continue;
    const std::uint64_t i = problem_.node(v)->id.value;
    const bool same = i < graph.nodeSlots().size() && graph.nodeSlots()[i] == problem_.node(v);
    // Another graph, unless the node is merely gone.
    if (!same && (i >= graph.nodeSlots().size() || graph.nodeSlots()[i])) {
      reset();
      break;
    }
  }
  removeMissing(graph);
  removed_edges_ = graph.nextEdgeId().value - graph.edgeCount();
}

bool IncrementalSolver::synchronize(const CSceneGraph& graph, std::span<const NodeId> moved) {
  fresh_order_.reset();
  forgetMissing(graph);
  addNew(graph);
  for (const NodeId node : moved) {
    const int v = problem_.variableOf(node);
    if (v < 0) continue;
    state_.resize(static_cast<std::size_t>(problem_.node(v)->stateSize()));
    problem_.node(v)->readState(state_.data());
    problem_.setState(v, state_.data());
    factor_.forget(problem_, v);
    takeState(v);
  }
  return mostly_new_;
}

int IncrementalSolver::newestFactor() const {
  int f = problem_.factors() - 1;
  while (f >= 0 && !problem_.edge(f)) --f;
  return f;
}

bool IncrementalSolver::isPartOf(const CSceneGraph& graph) {
  const auto& slots = graph.edgeSlots();
  const auto is_there = [&](int f) {
    if (!problem_.edge(f)) return true;
    const std::uint64_t i = problem_.edge(f)->id.value;
    return i < slots.size() && slots[i] == problem_.edge(f);
  };
  // Ids are not used twice: without removals since, the newest edge speaks for all.
  const int newest = newestFactor();
  const std::size_t removed = graph.nextEdgeId().value - graph.edgeCount();
  if (removed == removed_edges_ && newest >= 0) return is_there(newest);
  for (int f = 0; f < problem_.factors(); ++f)
    if (!is_there(f)) return false;
  removed_edges_ = removed;
  return true;
}

void IncrementalSolver::takeState(int v) {
  problem_.forEachFactorOf(v, [this](int f) {
    touchCost(f);
    if (!needs_build_) factor_.tree().touchFactor(problem_, f);
  });
}

void IncrementalSolver::touchCost(int f) { mark(is_cost_, costs_, f); }

void IncrementalSolver::removeMissing(const CSceneGraph& graph) {
  const auto& slots = graph.edgeSlots();
  for (int f = 0; f < problem_.factors(); ++f) {
    if (!problem_.edge(f)) continue;
    const std::uint64_t i = problem_.edge(f)->id.value;
    if (i < slots.size() && slots[i] == problem_.edge(f)) continue;
    // Ids are not used twice in a graph, but another one may have the same.
    if (i < slots.size() && slots[i]) known_edges_ = 0;
    if (!needs_build_) factor_.tree().removeFactor(problem_, f);
    const auto variables = problem_.variablesOf(f);
    const std::vector<int> ends(variables.begin(), variables.end());
    problem_.removeFactor(f);
    for (const int v : ends) {
      if (!problem_.alive(v) || problem_.degree(v) > 0) continue;
      if (!needs_build_) factor_.tree().removeVariable(v);
      problem_.removeVariable(v);
    }
  }
}

void IncrementalSolver::addNew(const CSceneGraph& graph) {
  const int known = problem_.variables();
  std::vector<int> factors;
  // What a bounded life has left behind is not looked at again.
  for (std::size_t i = known_edges_; i < graph.edgeSlots().size(); ++i) {
    const auto& edge = graph.edgeSlots()[i];
    if (!edge || problem_.factorOf({i}) >= 0) continue;
    for (const NodeId node : edge->nodes) {
      if (problem_.variableOf(node) < 0) problem_.addVariable(graph.nodeSlots()[node.value]);
    }
    factors.push_back(problem_.addFactor(edge));
    touchCost(factors.back());
  }
  known_edges_ = graph.edgeSlots().size();
  if (factors.empty()) return;
  const int added = problem_.variables() - known;
  const bool mostly_new = added > kRenewalGrowth * known;
  mostly_new_ |= mostly_new;
  needs_build_ |= mostly_new;
  if (needs_build_) return;
  std::vector<int> variables(static_cast<std::size_t>(added));
  std::iota(variables.begin(), variables.end(), known);
  factor_.tree().append(problem_, variables);
  new_.insert(new_.end(), variables.begin(), variables.end());
  for (const int f : factors) factor_.tree().addFactor(problem_, f);
}

std::size_t IncrementalSolver::nodes() const {
  std::size_t count = 0;
  for (int v = 0; v < problem_.variables(); ++v) count += problem_.alive(v) ? 1 : 0;
  return count;
}

std::size_t IncrementalSolver::tangentSize() const {
  std::size_t sum = 0;
  for (int v = 0; v < problem_.variables(); ++v)
    if (problem_.alive(v)) sum += static_cast<std::size_t>(problem_.tangentSize(v));
  return sum;
}

bool IncrementalSolver::renewalIsDue() const {
  if (needs_build_ || work_on_fill_ > renewal_work_) return true;
  if (work_.size() < 2 * kWorkWindow) return false;
  // The average over the time between two renewals is least when the present step costs as much.
  const double total = std::accumulate(work_.begin(), work_.end(), renewal_work_);
  const double recent = std::accumulate(work_.end() - kWorkWindow, work_.end(), 0.0);
  return recent / kWorkWindow > total / static_cast<double>(work_.size());
}

void IncrementalSolver::orderAnew() {
  if (!fresh_order_) fresh_order_ = factor_.tree().order(problem_, context_);
}

void IncrementalSolver::renew() {
  orderAnew();
  // Only what is alive, by id, linearised where the estimates are.
  std::vector<std::pair<std::uint64_t, int>> nodes, edges;
  for (int v = 0; v < problem_.variables(); ++v)
    if (problem_.alive(v)) nodes.emplace_back(problem_.node(v)->id.value, v);
  for (int f = 0; f < problem_.factors(); ++f)
    if (problem_.edge(f)) edges.emplace_back(problem_.edge(f)->id.value, f);
  std::sort(nodes.begin(), nodes.end());
  std::sort(edges.begin(), edges.end());
  LiveProblem fresh;
  std::vector<int> renumbered(static_cast<std::size_t>(problem_.variables()), -1);
  for (const auto& [id, v] : nodes)
    renumbered[v] = fresh.addVariable(problem_.node(v), problem_.estimate(v));
  for (const auto& [id, f] : edges) fresh.addFactor(problem_.edge(f));
  problem_ = std::move(fresh);
  unmark(is_pending_, pending_);
  unmark(is_stale_, stale_);
  unmark(is_correction_, corrections_);
  unmark(is_cost_, costs_);
  new_.clear();
  drift_.clear();
  problem_.updateCosts();
  for (int& v : fresh_order_->order) v = renumbered[v];
  factor_.build(problem_, *fresh_order_, context_);
  fresh_order_.reset();
  needs_build_ = false;
  work_.clear();
  renewal_work_ = work_on_fill_ = 0.0;
  renewed_ = true;
}

bool IncrementalSolver::isFar(int v) const {
  const double* d = problem_.delta(v);
  for (int k = 0; k < problem_.tangentSize(v); ++k)
    if (std::abs(d[k]) > params_.relinearize_above) return true;
  return false;
}

void IncrementalSolver::correct(int f) {
  mark(is_correction_, corrections_, f);
  const bool is_dirty = is_dirty_[factor_.tree().frontOfFactor(problem_, f)] != 0;
  if (!is_dirty && !problem_.weightIsFarOff(f)) return;
  problem_.reweigh(f);
  factor_.tree().touchFactor(problem_, f);
}

void IncrementalSolver::relinearize(int v) {
  problem_.relinearize(v);
  factor_.forget(problem_, v);
  problem_.forEachFactorOf(v, [this](int f) { factor_.tree().touchFactor(problem_, f); });
}

void IncrementalSolver::attendToPending() {
  factor_.tree().dirtyPaths(is_dirty_);
  drift_.resize(static_cast<std::size_t>(problem_.variables()), 0.0);
  for (const int v : pending_) {
    if (!problem_.alive(v)) continue;
    drift_[v] = 0.0;
    if (insists_ || isFar(v)) {
      relinearize(v);
    } else {
      problem_.forEachFactorOf(v, [this](int f) { correct(f); });
    }
  }
  for (const int f : stale_) {
    if (problem_.edge(f)) correct(f);
  }
  unmark(is_pending_, pending_);
  unmark(is_stale_, stale_);
  insists_ = false;
}

void IncrementalSolver::takeStep(int v) {
  problem_.updateEstimate(v);
  mark(is_changed_, changed_, v);
  problem_.forEachFactorOf(v, [this](int f) { touchCost(f); });
}

void IncrementalSolver::updateCosts() {
  for (std::size_t i = 0; i < costs_.size(); ++i) {
    if (i + LiveProblem::kAhead < costs_.size()) problem_.prefetch(costs_[i + LiveProblem::kAhead]);
    const int f = costs_[i];
    if (!problem_.edge(f)) continue;
    problem_.updateCost(f);
    if (problem_.weightIsStale(f)) mark(is_stale_, stale_, f);
  }
  unmark(is_cost_, costs_);
}

bool IncrementalSolver::factorize() {
  const SingleThreaded single_threaded;
  // The next step would want it, too.
  if (needs_build_) renew();
  needs_build_ = factor_.factorize(problem_).has_value();
  return !needs_build_;
}

bool IncrementalSolver::updateModel(OptimizationReport& report) {
  {
    const PhaseTimer timer(report.numeric_ms);
    attendToPending();
    if (factor_.factorize(problem_)) return false;
  }
  if (factor_.lastFronts() > 0) ++report.factorizations;
  const PhaseTimer timer(report.solve_ms);
  for (const int f : corrections_) {
    for (const int v : problem_.variablesOf(f)) {
      if (!problem_.estimateIsUpToDate(v)) takeStep(v);
    }
  }
  updateCosts();
  factor_.correct(problem_, corrections_);
  unmark(is_correction_, corrections_);
  return true;
}

double IncrementalSolver::neglectedDeviations() const {
  return std::sqrt(2.0 * params_.neglected_share * problem_.cost() / problem_.tangentSize());
}

void IncrementalSolver::step(OptimizationReport& report) {
  {
    const PhaseTimer timer(report.solve_ms);
    for (const int v : factor_.solve(problem_, neglectedDeviations())) {
      drift_[v] += factor_.lastStep(v);
      takeStep(v);
    }
  }
  const PhaseTimer timer(report.linearize_ms);
  updateCosts();
  ++report.iterations;
}

void IncrementalSolver::prepare(OptimizationReport& report) {
  if (!renewalIsDue()) return;
  const PhaseTimer timer(report.ordering_ms);
  orderAnew();
}

void IncrementalSolver::account(double work) {
  const int n = problem_.variables();
  const double flops = factor_.tree().flops() / n;
  if (renewed_) {
    renewal_work_ = work + n * (n < kMany ? kRenewalPriceOfFew : kRenewalPriceOfMany);
    fresh_flops_ = flops;
  } else {
    work_.push_back(work);
    // When it has cost as much as a renewal, one would have been better before.
    work_on_fill_ += work * std::max(0.0, 1.0 - fresh_flops_ / flops);
  }
  renewed_ = false;
}

bool IncrementalSolver::solve(OptimizationReport& report) {
  const SingleThreaded single_threaded;
  unmark(is_changed_, changed_);
  if (!needs_build_) {
    start_.run(problem_, new_);
    // A covariance may have been asked for since they came.
    for (const int v : new_) takeState(v);
  }
  new_.clear();
  prepare(report);
  if (fresh_order_) {
    const PhaseTimer timer(report.symbolic_ms);
    renew();
  }
  updateCosts();
  report.cost_before = report.cost_after = problem_.cost();
  if (!std::isfinite(report.cost_before)) return false;

  // What is neglected may raise the cost; more than that is another matter.
  const double highest =
      report.cost_before * (1.0 + kCostRounding + params_.neglected_share) + kCostRounding;
  double work = 0.0, last_mismatch = std::numeric_limits<double>::infinity();
  for (int i = 0;; ++i) {
    if (!updateModel(report)) return false;
    work += factor_.lastFlops();
    const double model = problem_.linearizedCost() - factor_.modelDecrease();
    // Nothing to be gained by it: what has changed of the model waits for the next call.
    report.cost_after = problem_.cost();
    if (i > 0 && std::abs(report.cost_after - model) <= kWorthwhile * report.cost_after) break;
    if (i == kMaxSteps) return false;
    step(report);
    const double cost = problem_.cost();
    if (!std::isfinite(cost)) return false;
    const double mismatch = std::abs(cost - model);
    const bool good = mismatch <= kNonlinearity * cost && cost <= highest;
    insists_ = !good && (cost > report.cost_after || mismatch > kSlowContraction * last_mismatch);
    report.cost_after = cost;
    last_mismatch = mismatch;
    const double limit =
        params_.relinearize_above * (good || i == 0 ? 1.0 : kTighterRelinearization);
    for (const int v : changed_)
      if (insists_ || drift_[v] > limit) mark(is_pending_, pending_, v);
    if (good) break;
    if (pending_.empty() && stale_.empty()) break;
  }
  if (report.cost_after > highest) return false;
  account(work);
  report.stop = StopReason::kConverged;
  return true;
}

}  // namespace dynemo::backend
