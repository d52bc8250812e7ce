// Marginal covariances from the factor of the undamped normal equations.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "linearize.h"
#include "sparse_factor.h"

namespace dynemo::backend {

/// Factorises H at the graph's estimates. The value says why there is no inverse: a residual that
/// is not finite, or a free direction (a pivot that is rounding error only), with the node where it
/// shows.
std::optional<std::string> factorizeUndamped(const Problem& problem,
                                             const BlockStructure& structure, SparseFactor& factor);

/// Rows and columns of H⁻¹ that belong to the variables, in the order given.
MatrixX jointCovariance(const Problem& problem, const BlockStructure& structure,
                        SparseFactor& factor, std::span<const int> variables);

/// The variables' own blocks of H⁻¹; the factor must be supernodal.
std::vector<MatrixX> blockCovariances(const Problem& problem, const BlockStructure& structure,
                                      const SparseFactor& factor, std::span<const int> variables);

}  // namespace dynemo::backend
