#include "live_problem.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dynemo::backend {
namespace {

/// Change of a robust weight that asks for a new linearisation.
constexpr float kStaleWeight = 0.03F;

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
  nodes_[v]->retract(&linearization_[state_offset_[v]], &delta_[tangent_offset_[v]],
                     &estimate_[state_offset_[v]]);
}

void LiveProblem::relinearize(int v) {
  const auto n = static_cast<std::size_t>(nodes_[v]->stateSize());
  std::copy_n(&estimate_[state_offset_[v]], n, &linearization_[state_offset_[v]]);
  std::fill_n(&delta_[tangent_offset_[v]], tangentSize(v), 0.0);
}

void LiveProblem::discardSteps() {
  estimate_ = linearization_;
  std::fill(delta_.begin(), delta_.end(), 0.0);
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

double LiveProblem::linearize(int factor, WhitenedFactor& out) {
  double weight = 1.0;
  linearized_cost_[factor] =
      whitenedFactor(*edges_[factor], pointers(factor, linearization_), out, &weight);
  linearized_weight_[factor] = static_cast<float>(weight);
  return linearized_cost_[factor];
}

void LiveProblem::updateCost(int factor) {
  const WeightedCost at = weightedCost(*edges_[factor], pointers(factor, estimate_));
  cost_[factor] = at.cost;
  weight_[factor] = static_cast<float>(at.weight);
}

bool LiveProblem::weightIsStale(int factor) const {
  return std::abs(weight_[factor] - linearized_weight_[factor]) > kStaleWeight;
}

double LiveProblem::linearizedCost() const {
  return std::accumulate(linearized_cost_.begin(), linearized_cost_.end(), 0.0);
}

double LiveProblem::cost() const { return std::accumulate(cost_.begin(), cost_.end(), 0.0); }

}  // namespace dynemo::backend
