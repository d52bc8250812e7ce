// One factor as the solver sees it: residual and Jacobians scaled so that cost, gradient and
// Hessian are plain products.
#pragma once

#include <span>

#include "dynemo/graph/edge.h"

namespace dynemo::backend {

/// Blocks are scaled by √ρ' and U, so that the sums need products of them only.
struct WhitenedFactor {
  Residual e;
  Jacobians J;
};

/// Evaluates the edge at the states of its nodes. Returns its cost ½ ρ(eᵀΩe), and its weight ρ'
/// when asked for.
double whitenedFactor(const CEdgeBase& edge, std::span<const double* const> states,
                      WhitenedFactor& out, double* weight = nullptr);

/// The same under a given weight.
double whitenedFactor(const CEdgeBase& edge, std::span<const double* const> states, double weight,
                      WhitenedFactor& out);

/// U e alone; returns cost and weight.
struct WeightedCost {
  double cost, weight;
};
WeightedCost whitenedResidual(const CEdgeBase& edge, std::span<const double* const> states,
                              Residual& out);

/// The cost alone; not finite when the residual is not.
double factorCost(const CEdgeBase& edge, std::span<const double* const> states);
/// The same with the weight ρ' that the robust kernel gives the edge.
WeightedCost weightedCost(const CEdgeBase& edge, std::span<const double* const> states);

/// out += AᵀB, a block with leading dimension `stride`.
void addProduct(const JacobianBlock& A, const JacobianBlock& B, double* out, int stride);

}  // namespace dynemo::backend
