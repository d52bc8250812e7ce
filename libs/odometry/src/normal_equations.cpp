#include "normal_equations.h"

namespace dynemo {

void NormalEquations::add(const WeightedResidual& r) {
  Vector6 a;
  a << r.b, r.s.cross(r.b);
  Vector6 pull;
  pull << r.e, r.s.cross(r.e);
  double wn = r.weight_normal, wi = r.weight_isotropic;
  const Vector6 force = wn * r.along_normal * a + wi * pull;
  double tau_power = 1.0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(orders_); ++k) {
    std::size_t entry = 0;
    for (int row = 0; row < 6; ++row) {
      const double scaled = wn * a[row];
      for (int col = row; col < 6; ++col) normal_[k][entry++] += scaled * a[col];
    }
    gradient_[k] += tau_power * force;
    mass_[k] += wi;
    moment_[k] += wi * r.s;
    inertia_[k].noalias() += (wi * r.s) * r.s.transpose();
    tau_power *= r.tau_s;
    wn *= r.tau_s;
    wi *= r.tau_s;
  }
  weight_sum += r.weight_normal;
  squared_residuals += r.weight_normal * r.along_normal * r.along_normal;
  squared_levers += r.weight_normal * r.s.squaredNorm();
}

void NormalEquations::add(const NormalEquations& other) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(orders_); ++k) {
    for (std::size_t i = 0; i < kUpper; ++i) normal_[k][i] += other.normal_[k][i];
    gradient_[k] += other.gradient_[k];
    mass_[k] += other.mass_[k];
    moment_[k] += other.moment_[k];
    inertia_[k] += other.inertia_[k];
  }
  matched += other.matched;
  inliers += other.inliers;
  weight_sum += other.weight_sum;
  squared_residuals += other.squared_residuals;
  squared_levers += other.squared_levers;
}

Matrix6 NormalEquations::normalHessian(int order) const {
  Matrix6 H;
  std::size_t entry = 0;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      H(row, col) = H(col, row) = normal_[static_cast<std::size_t>(order)][entry++];
    }
  }
  return H;
}

Matrix6 NormalEquations::hessian(int order) const {
  const auto k = static_cast<std::size_t>(order);
  Matrix6 H = normalHessian(order);
  // AᵀA = [I, −[s]×; [s]×, |s|² I − s sᵀ].
  const Matrix3 cross = skew(moment_[k]);
  H.topLeftCorner<3, 3>() += mass_[k] * Matrix3::Identity();
  H.topRightCorner<3, 3>() -= cross;
  H.bottomLeftCorner<3, 3>() += cross;
  H.bottomRightCorner<3, 3>() += inertia_[k].trace() * Matrix3::Identity() - inertia_[k];
  return H;
}

Vector6 NormalEquations::gradient(int order) const {
  return gradient_[static_cast<std::size_t>(order)];
}

}  // namespace dynemo
