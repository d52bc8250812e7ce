#include "marginals.h"

#include <cmath>

#include "selected_inverse.h"

namespace dynemo::backend {
namespace {

/// A pivot below this fraction of its diagonal entry is what rounding leaves of zero.
constexpr double kSingularPivot = 1e-13;

}  // namespace

std::optional<std::string> factorizeUndamped(const Problem& problem,
                                             const BlockStructure& structure,
                                             SparseFactor& factor) {
  const std::vector<double> states = problem.readStates();
  NormalEquations equations;
  linearize(problem, structure, states, equations);
  if (!std::isfinite(equations.cost)) {
    const int f = firstNonFiniteFactor(problem, states);
    return (f < 0 ? std::string("the sum of all edges") : problem.describeFactor(f)) +
           " has a cost that is not finite";
  }
  const auto free_at = [&](int entry) {
    return "the estimate is free to move (no prior fixes the gauge, or a part is not connected): " +
           problem.describeVariable(structure.variableAt(entry));
  };
  if (const auto bad_pivot = factor.factorize(structure, equations.hessian))
    return free_at(*bad_pivot);
  const VectorX pivots = factor.diagonal();
  for (int i = 0; i < structure.size(); ++i) {
    const double h = equations.hessian[structure.diagonal()[i]];
    if (!(pivots[i] * pivots[i] > kSingularPivot * h)) return free_at(i);
  }
  return std::nullopt;
}

MatrixX jointCovariance(const Problem& problem, const BlockStructure& structure,
                        SparseFactor& factor, std::span<const int> variables) {
  std::vector<int> entries;
  for (const int v : variables) {
    for (int i = 0; i < problem.connectivity().tangent_size[v]; ++i) {
      entries.push_back(structure.tangentOffset(v) + i);
    }
  }
  const auto n = static_cast<Eigen::Index>(entries.size());
  MatrixX unit = MatrixX::Zero(structure.size(), n);
  for (Eigen::Index c = 0; c < n; ++c) unit(entries[c], c) = 1.0;
  const MatrixX columns = factor.solve(unit);
  MatrixX joint(n, n);
  for (Eigen::Index r = 0; r < n; ++r) joint.row(r) = columns.row(entries[r]);
  return 0.5 * (joint + joint.transpose());
}

std::vector<MatrixX> blockCovariances(const Problem& problem, const BlockStructure& structure,
                                      const SparseFactor& factor, std::span<const int> variables) {
  const SelectedInverse inverse(factor.raw());
  std::vector<MatrixX> blocks;
  for (const int v : variables) {
    blocks.push_back(
        inverse.diagonalBlock(structure.tangentOffset(v), problem.connectivity().tangent_size[v]));
  }
  return blocks;
}

}  // namespace dynemo::backend
