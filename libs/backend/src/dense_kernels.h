// Dense partial Cholesky factorisation of one front.
#pragma once

namespace dynemo::backend {

/// Rows below a matrix that whole registers reach.
constexpr int kPaddingRows = 7;

/// A is the lower trapezoid of a symmetric matrix, column-major with leading dimension `ld`, `rows`
/// rows, and below them kPaddingRows of zeros, which stay zeros. Replaces its first `pivots`
/// columns by those of the Cholesky factor and subtracts their outer product from the rest of the
/// lower triangle. Returns the first column whose pivot is not positive, or −1. Entries above the
/// diagonal are left undefined. The same bits on every processor with fused multiplication and
/// addition.
int factorizePivots(double* A, int ld, int rows, int pivots);

/// x ← [y; x₂ − L₂₁ y] with y = L₁₁⁻¹ x₁: the step of a forward substitution.
void forwardSubstitute(const double* L, int ld, int rows, int pivots, double* x);

/// The same for so many right-hand sides at once, those of a row side by side.
constexpr int kSides = 8;
void forwardSubstituteSides(const double* L, int ld, int rows, int pivots, double* x);

/// y ← L₁₁⁻ᵀ (y − L₂₁ᵀ x), L the first `pivots` columns of a front of `rows` rows: the step of a
/// back substitution.
void backSubstitute(const double* L, int ld, int rows, int pivots, const double* x, double* y);

}  // namespace dynemo::backend
