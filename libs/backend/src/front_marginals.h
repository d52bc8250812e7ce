// Marginal covariances from the factorised fronts, without an inverse of anything larger than a
// front.
#pragma once

#include <span>
#include <vector>

#include "front_factor.h"
#include "live_problem.h"

namespace dynemo::backend {

/// Rows and columns of H⁻¹ that belong to the variables, in the order given: a forward and a back
/// substitution over the fronts between the variables and the root.
MatrixX jointCovariance(const LiveProblem& problem, const FrontFactor& factor,
                        std::span<const int> variables);

/// Aᵀ H⁻¹ A, where A has a row for every tangent entry of the problem.
MatrixX quadraticForm(const LiveProblem& problem, const FrontFactor& factor, const MatrixX& A);

/// The variables' own blocks of H⁻¹, by the recursion of selected_inverse.h from the root down to
/// the fronts that eliminate them.
std::vector<MatrixX> blockCovariances(const LiveProblem& problem, const FrontFactor& factor,
                                      std::span<const int> variables);

}  // namespace dynemo::backend
