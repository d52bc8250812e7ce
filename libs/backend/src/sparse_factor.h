// The Cholesky factor of the (damped) normal equations.
#pragma once

#include <optional>
#include <vector>

#include "block_structure.h"
#include "cholmod_context.h"

namespace dynemo::backend {

/// Supernodal for problems with enough fill to feed the BLAS, simplicial below; always LLᵀ.
/// Symbolic once per structure, then numeric as often as needed in the same storage.
class SparseFactor {
 public:
  enum class Kind { kFastest, kSupernodal };

  /// Symbolic analysis. Throws std::runtime_error when memory runs out.
  SparseFactor(const BlockStructure& structure, CholmodContext& context,
               Kind kind = Kind::kFastest);

  /// Factorises H (values as the structure lays them out). Returns the tangent entry, in
  /// elimination order, whose pivot is not positive; empty when the factor can be used.
  std::optional<int> factorize(const BlockStructure& structure, std::vector<double>& hessian);

  /// x = H⁻¹ b, in elimination order; columns of b are right-hand sides.
  void solve(const VectorX& b, VectorX& x);
  MatrixX solve(const MatrixX& b);

  /// Diagonal of L.
  VectorX diagonal() const;
  double nonZeros() const { return fill_; }
  /// CHOLMOD's factor, for algorithms on its supernodes.
  const cholmod_factor& raw() const { return *factor_; }

 private:
  CholmodContext* context_;
  FactorPtr factor_;
  double fill_ = 0.0;
  /// Kept between solves.
  DensePtr solution_, work_y_, work_e_;
};

}  // namespace dynemo::backend
