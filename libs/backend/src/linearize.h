// Evaluates the factors: cost, gradient and Gauss–Newton Hessian.
#pragma once

#include <span>
#include <vector>

#include "block_structure.h"
#include "problem.h"

namespace dynemo::backend {

/// H = Σ ρ' JᵀΩJ and g = Σ ρ' JᵀΩe in elimination order; values of H as BlockStructure lays them
/// out.
struct NormalEquations {
  std::vector<double> hessian;
  VectorX gradient;
  double cost = 0.0;  ///< F = ½ Σ ρ(eᵀΩe)
};

/// Cost at the states; not finite when some residual is not.
double evaluateCost(const Problem& problem, const std::vector<double>& states);

/// Fills the normal equations at the states. Factors are added in the order of their ids, so equal
/// input gives equal bits.
void linearize(const Problem& problem, const BlockStructure& structure,
               const std::vector<double>& states, NormalEquations& out);

/// The first factor whose cost at the states is not finite, or −1.
int firstNonFiniteFactor(const Problem& problem, const std::vector<double>& states);

/// states ⊞ delta, delta in elimination order.
void retract(const Problem& problem, const BlockStructure& structure,
             const std::vector<double>& states, const VectorX& delta, std::vector<double>& out);

}  // namespace dynemo::backend
