#include "dynemo/core/noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>

namespace dynemo {
namespace {

bool isSymmetric(const MatrixX& m) {
  return m.rows() == m.cols() && m.allFinite() &&
         (m - m.transpose()).cwiseAbs().maxCoeff() <=
             1e-9 * std::max(m.cwiseAbs().maxCoeff(), 1e-300);
}

}  // namespace

std::optional<MatrixX> squareRootInformation(const MatrixX& information) {
  if (!isSymmetric(information)) return std::nullopt;
  const Eigen::LLT<MatrixX> llt(information);
  if (llt.info() != Eigen::Success) return std::nullopt;
  MatrixX U = llt.matrixU();
  if (!U.allFinite() || U.diagonal().minCoeff() <= 0.0) return std::nullopt;
  return U;
}

std::optional<MatrixX> invertSpd(const MatrixX& m) {
  if (!isSymmetric(m)) return std::nullopt;
  const Eigen::LLT<MatrixX> llt(m);
  if (llt.info() != Eigen::Success) return std::nullopt;
  MatrixX inverse = llt.solve(MatrixX::Identity(m.rows(), m.cols()));
  if (!inverse.allFinite()) return std::nullopt;
  return MatrixX(0.5 * (inverse + inverse.transpose()));
}

Matrix6 isotropicCovariance(double sigma_translation_m, double sigma_rotation_rad) {
  Vector6 d;
  d << Vector3::Constant(sigma_translation_m * sigma_translation_m),
      Vector3::Constant(sigma_rotation_rad * sigma_rotation_rad);
  return d.asDiagonal();
}

Matrix6 floorCovariance(const Matrix6& cov, double min_sigma_translation_m,
                        double min_sigma_rotation_rad) {
  // Adding to the diagonal blocks keeps the whole positive definite, which replacing eigenvalues
  // would not.
  Matrix6 floored = cov;
  const auto raise = [&](int at, double min_sigma) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> es(cov.block<3, 3>(at, at));
    const Vector3 missing =
        (Vector3::Constant(min_sigma * min_sigma) - es.eigenvalues()).cwiseMax(0.0);
    floored.block<3, 3>(at, at) +=
        es.eigenvectors() * missing.asDiagonal() * es.eigenvectors().transpose();
  };
  raise(0, min_sigma_translation_m);
  raise(3, min_sigma_rotation_rad);
  return 0.5 * (floored + floored.transpose());
}

double squaredMahalanobis(const VectorX& e, const MatrixX& covariance) {
  const Eigen::LLT<MatrixX> llt(covariance);
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return llt.matrixL().solve(e).squaredNorm();
}

double chiSquaredQuantile(int dof, double probability) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

}  // namespace dynemo
