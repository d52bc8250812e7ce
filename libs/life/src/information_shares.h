// How much of what is known may be given to each of several measurements, so that together they do
// not claim more.
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
  /// (J Σ Jᵀ)⁻¹: all that is known of it.
  MatrixX information;
};

/// Shares α in [0, 1] with Σ α Jᵀ Ω J ≼ Λ + `slack`: no direction is known better than it was
/// (N. Carlevaris-Bianco and R. Eustice, "Conservative edge sparsification for graph SLAM node
/// removal", ICRA 2014). All grow together; one that cannot grow further stays behind.
std::vector<double> informationShares(const MatrixX& information,
                                      const std::vector<PairMeasurement>& measurements,
                                      double slack);

}  // namespace dynemo::life
