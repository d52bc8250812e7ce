// The information matrices of measurements between pairs of nodes that together say best what is
// known of all the nodes.
#pragma once

#include <vector>

#include "dynemo/core/noise.h"

namespace dynemo::life {

/// The rows and columns of two blocks of a square matrix, side by side.
MatrixX jointBlock(const MatrixX& all, int at_a, int size_a, int at_b, int size_b);

/// A measurement of two blocks of a vector: e = J [x_a; x_b].
struct PairMeasurement {
  int at_a = 0, size_a = 0, at_b = 0, size_b = 0;
  MatrixX J;
  /// J Σ Jᵀ: all that is known of it.
  MatrixX covariance;
};

/// Matrices Xᵢ ≽ 0 for which Λ' = `slack` I + Σ Jᵢᵀ Xᵢ Jᵢ is nearest to the information Σ⁻¹ by the
/// Kullback–Leibler divergence: they minimise tr(Λ' Σ) − ln|Λ'| (M. Mazuran, W. Burgard and
/// G. D. Tipaldi, "Nonlinear factor recovery for long-term SLAM", IJRR 2016), found one by one in
/// closed form, in rounds. What is known of a measured pair is kept; it is what is known of all
/// others that may differ. Of a tree, Xᵢ = (Jᵢ Σ Jᵢᵀ)⁻¹.
std::vector<MatrixX> pairInformation(int size, const std::vector<PairMeasurement>& measurements,
                                     double slack);

}  // namespace dynemo::life
