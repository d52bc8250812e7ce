#include "linearize.h"

#include <array>
#include <cmath>

#include "whitened_factor.h"

namespace dynemo::backend {
namespace {

using Place = BlockStructure::Target::Place;
using Pointers = std::array<const double*, kMaxEdgeNodes>;

std::span<const double* const> statePointers(const Problem& problem, int factor,
                                             const std::vector<double>& states,
                                             Pointers& pointers) {
  const auto variables = problem.connectivity().variablesOf(factor);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    pointers[i] = &states[problem.stateOffset(variables[i])];
  }
  return {pointers.data(), variables.size()};
}

double factorCost(const Problem& problem, int factor, const std::vector<double>& states) {
  Pointers pointers;
  return backend::factorCost(problem.edge(factor),
                             statePointers(problem, factor, states, pointers));
}

/// Adds one factor and returns its cost.
double addFactor(const Problem& problem, const BlockStructure& structure, int f,
                 const std::vector<double>& states, WhitenedFactor& work, NormalEquations& out) {
  Pointers pointers;
  const CEdgeBase& edge = problem.edge(f);
  const double cost = whitenedFactor(edge, statePointers(problem, f, states, pointers), work);
  const auto variables = problem.connectivity().variablesOf(f);
  const BlockStructure::Target* target = structure.targets(f);
  for (std::size_t a = 0; a < variables.size(); ++a) {
    const JacobianBlock& A = work.J[a];
    out.gradient.segment(structure.tangentOffset(variables[a]), A.cols()).noalias() +=
        A.transpose().lazyProduct(work.e);
    for (std::size_t b = 0; b <= a; ++b, ++target) {
      const JacobianBlock& B = work.J[b];
      double* const block = &out.hessian[target->offset];
      if (target->place != Place::kTransposed) addProduct(A, B, block, target->stride);
      if (target->place != Place::kDirect) addProduct(B, A, block, target->stride);
    }
  }
  return cost;
}

}  // namespace

double evaluateCost(const Problem& problem, const std::vector<double>& states) {
  double cost = 0.0;
  for (int f = 0; f < problem.connectivity().factors(); ++f) cost += factorCost(problem, f, states);
  return cost;
}

void linearize(const Problem& problem, const BlockStructure& structure,
               const std::vector<double>& states, NormalEquations& out) {
  out.hessian.assign(structure.nonZeros(), 0.0);
  out.gradient.setZero(structure.size());
  out.cost = 0.0;
  WhitenedFactor work;
  for (int f = 0; f < problem.connectivity().factors(); ++f) {
    out.cost += addFactor(problem, structure, f, states, work, out);
  }
}

int firstNonFiniteFactor(const Problem& problem, const std::vector<double>& states) {
  for (int f = 0; f < problem.connectivity().factors(); ++f) {
    if (!std::isfinite(factorCost(problem, f, states))) return f;
  }
  return -1;
}

void retract(const Problem& problem, const BlockStructure& structure,
             const std::vector<double>& states, const VectorX& delta, std::vector<double>& out) {
  out.resize(states.size());
  for (int v = 0; v < problem.connectivity().variables(); ++v) {
    const std::size_t at = problem.stateOffset(v);
    problem.node(v).retract(&states[at], &delta[structure.tangentOffset(v)], &out[at]);
  }
}

}  // namespace dynemo::backend
