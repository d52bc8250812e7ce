// The rest of the map, as it follows the few of its nodes that newer edges move.
#pragma once

#include <vector>

#include "front_paths.h"
#include "incremental_solver.h"

namespace dynemo::backend {

/// Of a solved map, Gaussian at its estimates, the mean when some of its nodes have moved: with the
/// map's covariance Σ = L⁻ᵀ L⁻¹ and the step t of those, Σ_·t Σ_tt⁻¹ t = L⁻ᵀ (L⁻¹ E_t) Σ_tt⁻¹ t.
/// The bracket is known and sparse; the substitution goes down from the roots, as far as anything
/// moves.
class MapFollower {
 public:
  /// The map must stay as it is until the next reset.
  void reset(const IncrementalSolver& map);
  /// Takes the columns L⁻¹ E_t of the moved nodes, and Σ_tt⁻¹ t. Returns the variables of the map
  /// that have moved by more than `tolerance` [m, rad] since they were last returned.
  const std::vector<int>& follow(const std::vector<PathColumns>& columns, const VectorX& weights,
                                 double tolerance);
  /// What the rest costs that is not returned, about: ½ Σ of its squares in standard deviations,
  /// given what is eliminated later.
  double neglectedCost() const { return neglected_cost_; }
  /// How far it has moved from the map's estimate, in its tangent.
  const double* step(int variable) const;

 private:
  void gather(const std::vector<PathColumns>& columns, const VectorX& weights);
  bool anyMoved(const Front::List& list) const;
  void solveFront(int front, double tolerance);

  const IncrementalSolver* map_ = nullptr;
  std::vector<double> step_, returned_;  ///< by tangent entry
  std::vector<double> neglected_;        ///< cost, per variable
  double neglected_cost_ = 0.0;
  std::vector<char> moved_;          ///< per variable, in the call in work
  std::vector<VectorX> right_hand_;  ///< per front; empty where no path leads
  std::vector<int> paths_, changed_, stack_;
  VectorX x_, y_;
};

}  // namespace dynemo::backend
