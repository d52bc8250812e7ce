// The least-squares problem of a scene graph that changes while it is solved.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dynemo/graph/scene_graph.h"
#include "whitened_factor.h"

namespace dynemo::backend {

/// Variables and factors in flat arrays that grow at the end; numbers of removed ones stay unused
/// until the problem is built anew. A variable has the state it was linearised at, x₀, a tangent
/// step δ from there, and the estimate x = x₀ ⊞ δ. Nodes and edges are held by shared pointers, so
/// that the graph may drop them; an edge must not change once it is in the graph.
///
/// A factor's part of the quadratic model is that of its linearisation, until correct() gives it
/// the residual, weight and cost that it has elsewhere, under the same Jacobians. (With other
/// Jacobians, too, the forces between nodes would no longer balance under the old Hessian, and move
/// the map as a whole.)
class LiveProblem {
 public:
  int variables() const { return static_cast<int>(nodes_.size()); }
  int factors() const { return static_cast<int>(edges_.size()); }
  int tangentSize() const { return static_cast<int>(delta_.size()); }

  /// The node's current estimate, or the given state, becomes x₀ and x. A constant has no tangent.
  int addVariable(const CNodeBase::Ptr& node, const double* state = nullptr, bool constant = false);
  int addFactor(const CEdgeBase::Ptr& edge);
  void removeFactor(int factor);
  void removeVariable(int variable);

  bool alive(int variable) const { return nodes_[variable] != nullptr; }
  const CNodeBase::Ptr& node(int variable) const { return nodes_[variable]; }
  const CEdgeBase::Ptr& edge(int factor) const { return edges_[factor]; }
  /// −1 when the node or edge is not part of the problem.
  int variableOf(NodeId node) const { return at(variable_of_node_, node.value); }
  int factorOf(EdgeId edge) const { return at(factor_of_edge_, edge.value); }
  std::size_t nodeSlots() const { return variable_of_node_.size(); }
  std::size_t edgeSlots() const { return factor_of_edge_.size(); }

  int tangentSize(int variable) const {
    return tangent_offset_[variable + 1] - tangent_offset_[variable];
  }
  int tangentOffset(int variable) const { return tangent_offset_[variable]; }
  double* delta(int variable) { return delta_.data() + tangent_offset_[variable]; }
  const double* delta(int variable) const { return delta_.data() + tangent_offset_[variable]; }
  const double* estimate(int variable) const { return &estimate_[state_offset_[variable]]; }

  std::span<const int> variablesOf(int factor) const {
    return {&factor_variables_[kMaxEdgeNodes * static_cast<std::size_t>(factor)],
            static_cast<std::size_t>(factor_size_[factor])};
  }
  /// Calls visit(factor) for every factor of the variable.
  template <class Visit>
  void forEachFactorOf(int variable, Visit visit) const {
    for (int i = first_incidence_[variable]; i >= 0; i = next_incidence_[i])
      visit(i / kMaxEdgeNodes);
  }
  int degree(int variable) const { return degree_[variable]; }

  /// x ← x₀ ⊞ δ.
  void updateEstimate(int variable);
  bool estimateIsUpToDate(int variable) const;
  /// x₀ ← x, δ ← 0.
  void relinearize(int variable);
  /// x ← x₀, δ ← 0, of all.
  void discardSteps();
  /// x₀ ← x ← the state, δ ← 0.
  void setState(int variable, const double* state);

  /// Has the numbers of a factor (if there is one) on their way from memory before they are used;
  /// so many factors ahead is early enough.
  void prefetch(int factor) const;
  static constexpr int kAhead = 8;
  /// Linearises a factor at x₀; returns its cost there and remembers cost and weight.
  double linearize(int factor, WhitenedFactor& out);
  /// The cost at x is kept per factor and brought up to date by this.
  void updateCost(int factor);
  void updateCosts();
  /// Whether the robust weight at x has left the one of the linearisation.
  bool weightIsStale(int factor) const;
  /// Whether it has changed so much that the Hessian is no longer that of the cost.
  bool weightIsFarOff(int factor) const;
  /// From the next linearisation on the factor has the weight that it has at x, until one of its
  /// variables moves its x₀.
  void reweigh(int factor);
  /// Makes the residual of the model, and its cost, that of the factor at x, for which the
  /// estimates of its nodes must be up to date. Returns what that adds to the residual; `out` has
  /// the Jacobians.
  const Residual& correct(int factor, WhitenedFactor& out);
  /// Sums over all factors, of the model at x₀ (as far as linearised) and of the cost at x.
  double linearizedCost() const;
  double cost() const;
  double cost(int factor) const { return cost_[factor]; }

 private:
  static int at(const std::vector<int>& map, std::uint64_t i) {
    return i < map.size() ? map[i] : -1;
  }
  std::span<const double* const> pointers(int factor, const std::vector<double>& states) const;
  void evaluateAnew(int factor);

  std::vector<CNodeBase::Ptr> nodes_;
  std::vector<std::size_t> state_offset_;
  std::vector<int> tangent_offset_ = {0};
  std::vector<double> linearization_, estimate_, delta_;
  std::vector<double> evaluated_;  ///< δ of the estimate
  std::vector<int> first_incidence_, degree_;

  std::vector<CEdgeBase::Ptr> edges_;
  std::vector<int> factor_size_, factor_variables_, next_incidence_;
  std::vector<double> linearized_cost_, cost_;
  std::vector<float> linearized_weight_, weight_;
  std::vector<float> held_weight_;        ///< of the linearisation; −1: the one at x₀
  std::vector<int> correction_;           ///< of the factor, in corrections_, or −1
  std::vector<float> correction_weight_;  ///< of the robust kernel where it was made
  std::vector<Residual> corrections_;     ///< added to the residual at x₀
  std::vector<int> free_corrections_;

  std::vector<int> variable_of_node_, factor_of_edge_;
  Residual change_;
  mutable std::array<const double*, kMaxEdgeNodes> pointers_{};
};

}  // namespace dynemo::backend
