#include "live_problem.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dynemo::backend {
namespace {

/// Change of a robust weight that asks for a new linearisation.
constexpr float kStaleWeight = 0.03F;
/// And the share of the larger weight that asks for another Hessian.
constexpr float kFarOffWeight = 0.5F;

constexpr int kCacheLine = 64;
/// From an edge's information on, with what it measured behind.
constexpr int kEdgeLines = 7;

void put(std::vector<int>& map, std::uint64_t i, int value) {
  if (i >= map.size()) map.resize(i + 1, -1);
  map[i] = value;
}

}  // namespace

int LiveProblem::addVariable(const CNodeBase::Ptr& node, const double* state, bool constant) {
  const int v = variables();
  nodes_.push_back(node);
  put(variable_of_node_, node->id.value, v);
  state_offset_.push_back(estimate_.size());
  const auto size = static_cast<std::size_t>(node->stateSize());
  estimate_.resize(estimate_.size() + size);
  double* const x = &estimate_[state_offset_.back()];
  state ? static_cast<void>(std::copy_n(state, size, x)) : node->readState(x);
  linearization_.insert(linearization_.end(),
                        estimate_.begin() + static_cast<std::ptrdiff_t>(state_offset_.back()),
                        estimate_.end());
  tangent_offset_.push_back(tangent_offset_.back() + (constant ? 0 : node->tangentSize()));
  delta_.resize(static_cast<std::size_t>(tangent_offset_.back()), 0.0);
  evaluated_.resize(delta_.size(), 0.0);
  first_incidence_.push_back(-1);
  degree_.push_back(0);
  return v;
}

int LiveProblem::addFactor(const CEdgeBase::Ptr& edge) {
  const int f = factors();
  edges_.push_back(edge);
  put(factor_of_edge_, edge->id.value, f);
  factor_size_.push_back(static_cast<int>(edge->nodes.size()));
  factor_variables_.resize(factor_variables_.size() + kMaxEdgeNodes, -1);
  next_incidence_.resize(next_incidence_.size() + kMaxEdgeNodes, -1);
  for (std::size_t i = 0; i < edge->nodes.size(); ++i) {
    const int v = variableOf(edge->nodes[i]), slot = kMaxEdgeNodes * f + static_cast<int>(i);
    factor_variables_[slot] = v;
    bool repeated = false;
    for (int s = kMaxEdgeNodes * f; s < slot; ++s) repeated |= factor_variables_[s] == v;
    if (repeated) continue;
    next_incidence_[slot] = first_incidence_[v];
    first_incidence_[v] = slot;
    ++degree_[v];
  }
  linearized_cost_.push_back(0.0);
  linearized_weight_.push_back(1.0F);
  cost_.push_back(0.0);
  weight_.push_back(1.0F);
  correction_.push_back(-1);
  correction_weight_.push_back(1.0F);
  held_weight_.push_back(-1.0F);
  return f;
}

void LiveProblem::removeFactor(int factor) {
  for (const int v : variablesOf(factor)) {
    int* link = &first_incidence_[v];
    while (*link >= 0 && *link / kMaxEdgeNodes != factor) link = &next_incidence_[*link];
    if (*link < 0) continue;
    *link = next_incidence_[*link];
    --degree_[v];
  }
  evaluateAnew(factor);
  factor_of_edge_[edges_[factor]->id.value] = -1;
  edges_[factor].reset();
  factor_size_[factor] = 0;
  linearized_cost_[factor] = cost_[factor] = 0.0;
}

void LiveProblem::removeVariable(int variable) {
  variable_of_node_[nodes_[variable]->id.value] = -1;
  nodes_[variable].reset();
}

void LiveProblem::updateEstimate(int v) {
  if (tangentSize(v) == 0) return;  // a constant
  nodes_[v]->retract(&linearization_[state_offset_[v]], delta(v), &estimate_[state_offset_[v]]);
  std::copy_n(delta(v), tangentSize(v), evaluated_.data() + tangent_offset_[v]);
}

bool LiveProblem::estimateIsUpToDate(int v) const {
  return std::equal(delta(v), delta(v) + tangentSize(v), evaluated_.data() + tangent_offset_[v]);
}

void LiveProblem::relinearize(int v) {
  const auto n = static_cast<std::size_t>(nodes_[v]->stateSize());
  std::copy_n(&estimate_[state_offset_[v]], n, &linearization_[state_offset_[v]]);
  std::fill_n(delta(v), tangentSize(v), 0.0);
  std::fill_n(evaluated_.data() + tangent_offset_[v], tangentSize(v), 0.0);
  if (corrections_.size() > free_corrections_.size())
    forEachFactorOf(v, [this](int f) { evaluateAnew(f); });
}

void LiveProblem::discardSteps() {
  estimate_ = linearization_;
  std::fill(delta_.begin(), delta_.end(), 0.0);
  std::fill(evaluated_.begin(), evaluated_.end(), 0.0);
}

void LiveProblem::setState(int v, const double* state) {
  std::copy_n(state, nodes_[v]->stateSize(), &estimate_[state_offset_[v]]);
  relinearize(v);
}

std::span<const double* const> LiveProblem::pointers(int factor,
                                                     const std::vector<double>& states) const {
  const auto variables = variablesOf(factor);
  for (std::size_t i = 0; i < variables.size(); ++i)
    pointers_[i] = &states[state_offset_[variables[i]]];
  return {pointers_.data(), variables.size()};
}

void LiveProblem::prefetch(int factor) const {
  if (factor >= factors() || !edges_[factor]) return;
  const CEdgeBase* const edge = edges_[factor].get();
  __builtin_prefetch(edge);
  const char* const numbers = reinterpret_cast<const char*>(&edge->sqrtInformation());
  for (int line = 0; line < kEdgeLines; ++line) __builtin_prefetch(numbers + kCacheLine * line);
}

double LiveProblem::linearize(int factor, WhitenedFactor& out) {
  double weight = held_weight_[factor];
  const auto states = pointers(factor, linearization_);
  const double cost = weight < 0.0 ? whitenedFactor(*edges_[factor], states, out, &weight)
                                   : whitenedFactor(*edges_[factor], states, weight, out);
  linearized_weight_[factor] = static_cast<float>(weight);
  if (correction_[factor] < 0) {
    linearized_cost_[factor] = cost;
  } else {
    out.e += corrections_[correction_[factor]];
  }
  return linearized_cost_[factor];
}

void LiveProblem::updateCost(int factor) {
  const WeightedCost at = weightedCost(*edges_[factor], pointers(factor, estimate_));
  cost_[factor] = at.cost;
  weight_[factor] = static_cast<float>(at.weight);
}

void LiveProblem::updateCosts() {
  for (int f = 0; f < factors(); ++f) {
    prefetch(f + kAhead);
    if (edges_[f]) updateCost(f);
  }
}

bool LiveProblem::weightIsStale(int factor) const {
  const float known =
      correction_[factor] < 0 ? linearized_weight_[factor] : correction_weight_[factor];
  return std::abs(weight_[factor] - known) > kStaleWeight;
}

bool LiveProblem::weightIsFarOff(int factor) const {
  const float a = weight_[factor], b = linearized_weight_[factor];
  return std::abs(a - b) > kFarOffWeight * std::max(a, b);
}

void LiveProblem::reweigh(int factor) { held_weight_[factor] = weight_[factor]; }

const Residual& LiveProblem::correct(int f, WhitenedFactor& out) {
  linearize(f, out);
  Residual model = out.e;
  const auto variables = variablesOf(f);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const int v = variables[i];
    if (tangentSize(v) > 0)
      model.noalias() += out.J[i] * Eigen::Map<const VectorX>(delta(v), tangentSize(v));
  }
  const WeightedCost here = whitenedResidual(*edges_[f], pointers(f, estimate_), change_);
  // The Jacobians have √w of the linearisation; a weight of zero there says nothing here.
  const double w = linearized_weight_[f];
  change_ *= w > 0.0 ? here.weight / std::sqrt(w) : 0.0;
  const double rest = here.cost - 0.5 * change_.squaredNorm();
  change_ -= model;
  if (correction_[f] < 0) {
    if (free_corrections_.empty()) {
      free_corrections_.push_back(static_cast<int>(corrections_.size()));
      corrections_.emplace_back();
    }
    correction_[f] = free_corrections_.back();
    free_corrections_.pop_back();
    corrections_[correction_[f]].setZero(change_.size());
  }
  corrections_[correction_[f]] += change_;
  linearized_cost_[f] = rest + 0.5 * (out.e + change_).squaredNorm();
  correction_weight_[f] = static_cast<float>(here.weight);
  return change_;
}

void LiveProblem::evaluateAnew(int f) {
  held_weight_[f] = -1.0F;
  if (correction_[f] < 0) return;
  free_corrections_.push_back(correction_[f]);
  correction_[f] = -1;
}

double LiveProblem::linearizedCost() const {
  return std::accumulate(linearized_cost_.begin(), linearized_cost_.end(), 0.0);
}

double LiveProblem::cost() const { return std::accumulate(cost_.begin(), cost_.end(), 0.0); }

}  // namespace dynemo::backend
