#include "whitened_factor.h"

#include <cmath>

namespace dynemo::backend {
namespace {

/// out += AᵀB with all sizes known to the compiler.
template <int M, int Rows, int Columns>
void addProductFixed(const JacobianBlock& A, const JacobianBlock& B, double* out, int stride) {
  const Eigen::Map<const Eigen::Matrix<double, M, Rows>> a(A.data());
  const Eigen::Map<const Eigen::Matrix<double, M, Columns>> b(B.data());
  Eigen::Map<Eigen::Matrix<double, Rows, Columns>, 0, Eigen::OuterStride<>> target(
      out, Eigen::OuterStride<>(stride));
  target.noalias() += a.transpose().lazyProduct(b);
}

}  // namespace

void addProduct(const JacobianBlock& A, const JacobianBlock& B, double* out, int stride) {
  if (A.rows() == 6 && A.cols() == 6 && B.cols() == 6) {
    return addProductFixed<6, 6, 6>(A, B, out, stride);
  }
  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> target(out, A.cols(), B.cols(),
                                                              Eigen::OuterStride<>(stride));
  target.noalias() += A.transpose().lazyProduct(B);
}

namespace {

template <int M>
void whitenFixed(const InformationMatrix& U, double scale, std::size_t count,
                 WhitenedFactor& factor) {
  const Eigen::Matrix<double, M, M> scaled =
      scale * Eigen::Map<const Eigen::Matrix<double, M, M>>(U.data());
  factor.e = scaled * Eigen::Matrix<double, M, 1>(factor.e);
  for (std::size_t i = 0; i < count; ++i) {
    if (factor.J[i].cols() == 6) {
      Eigen::Map<Eigen::Matrix<double, M, 6>> J(factor.J[i].data());
      J = (scaled * J).eval();
    } else {
      factor.J[i] = (scaled * factor.J[i]).eval();
    }
  }
}

void whiten(const InformationMatrix& U, double scale, std::size_t count, WhitenedFactor& factor) {
  if (U.rows() == 6) return whitenFixed<6>(U, scale, count, factor);
  factor.e = scale * (U * factor.e).eval();
  for (std::size_t i = 0; i < count; ++i) factor.J[i] = scale * (U * factor.J[i]).eval();
}

}  // namespace

namespace {

template <int M>
double squaredNormFixed(const InformationMatrix& U, const Residual& e) {
  return (Eigen::Map<const Eigen::Matrix<double, M, M>>(U.data()) *
          Eigen::Map<const Eigen::Matrix<double, M, 1>>(e.data()))
      .squaredNorm();
}

/// ‖U e‖².
double whitenedSquaredNorm(const InformationMatrix& U, const Residual& e) {
  switch (e.size()) {
    case 6:
      return squaredNormFixed<6>(U, e);
    case 3:
      return squaredNormFixed<3>(U, e);
    default:
      return (U * e).squaredNorm();
  }
}

}  // namespace

double whitenedFactor(const CEdgeBase& edge, std::span<const double* const> states,
                      WhitenedFactor& out, double* weight) {
  edge.evaluate(states, out.e, &out.J);
  const RobustKernel::Value rho = edge.kernel(whitenedSquaredNorm(edge.sqrtInformation(), out.e));
  whiten(edge.sqrtInformation(), std::sqrt(rho.weight), states.size(), out);
  if (weight) *weight = rho.weight;
  return 0.5 * rho.rho;
}

double whitenedFactor(const CEdgeBase& edge, std::span<const double* const> states, double weight,
                      WhitenedFactor& out) {
  edge.evaluate(states, out.e, &out.J);
  const double squared_norm = whitenedSquaredNorm(edge.sqrtInformation(), out.e);
  whiten(edge.sqrtInformation(), std::sqrt(weight), states.size(), out);
  return 0.5 * edge.kernel(squared_norm).rho;
}

WeightedCost whitenedResidual(const CEdgeBase& edge, std::span<const double* const> states,
                              Residual& out) {
  edge.evaluate(states, out, nullptr);
  out = (edge.sqrtInformation() * out).eval();
  const RobustKernel::Value rho = edge.kernel(out.squaredNorm());
  return {0.5 * rho.rho, rho.weight};
}

WeightedCost weightedCost(const CEdgeBase& edge, std::span<const double* const> states) {
  Residual e;
  edge.evaluate(states, e, nullptr);
  const RobustKernel::Value rho = edge.kernel(whitenedSquaredNorm(edge.sqrtInformation(), e));
  return {0.5 * rho.rho, rho.weight};
}

double factorCost(const CEdgeBase& edge, std::span<const double* const> states) {
  return weightedCost(edge, states).cost;
}

}  // namespace dynemo::backend
