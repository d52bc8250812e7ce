// Covariances of single variables, of which more are asked for one by one.
#pragma once

#include <vector>

#include "front_factor.h"
#include "live_problem.h"

namespace dynemo::backend {

/// L⁻¹ E, where E selects the tangent of one variable: zero but on the pivots of the fronts from
/// the variable's to the root.
struct PathColumns {
  std::vector<int> fronts;     ///< from the variable's to the root
  std::vector<MatrixX> parts;  ///< on the pivots of each
};

/// The covariance between two variables, as far as their fronts are the same.
MatrixX covariance(const PathColumns& a, const PathColumns& b);

/// Makes them for a factorisation that must not change meanwhile.
class PathTracer {
 public:
  PathColumns trace(const LiveProblem& problem, const FrontTree& tree, int variable);

 private:
  /// Right-hand sides by tangent entry, kSides to each; zero in between.
  std::vector<double> carried_;
  std::vector<double> x_;  ///< of the front in work
};

}  // namespace dynemo::backend
