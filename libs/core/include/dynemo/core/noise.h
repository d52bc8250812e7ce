// Covariance, information and whitening.
#pragma once

#include <optional>

#include "dynemo/core/se3.h"

namespace dynemo {

using MatrixX = Eigen::MatrixXd;
using VectorX = Eigen::VectorXd;

/// U with UᵀU = information, so that ‖U e‖² = eᵀ Ω e. Empty when the matrix is not symmetric
/// positive definite (relative to its largest entry).
std::optional<MatrixX> squareRootInformation(const MatrixX& information);

/// Inverse of a symmetric positive definite matrix; empty when it is not.
std::optional<MatrixX> invertSpd(const MatrixX& m);

/// diag(σ_t², σ_t², σ_t², σ_r², σ_r², σ_r²).
Matrix6 isotropicCovariance(double sigma_translation_m, double sigma_rotation_rad);

/// Raises the eigenvalues of the translation and of the rotation block to at least the given
/// variances, leaving their correlation with each other in place where it stays consistent.
Matrix6 floorCovariance(const Matrix6& cov, double min_sigma_translation_m,
                        double min_sigma_rotation_rad);

/// eᵀ Σ⁻¹ e; +∞ when Σ is singular.
double squaredMahalanobis(const VectorX& e, const MatrixX& covariance);

/// Quantile of the χ² distribution with `dof` degrees of freedom, probability in (0, 1).
double chiSquaredQuantile(int dof, double probability);

}  // namespace dynemo
