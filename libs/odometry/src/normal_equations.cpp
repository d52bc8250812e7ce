#include "normal_equations.h"

namespace dynemo {

NormalEquations::Terms NormalEquations::termsOf(const Vector6& a, const WeightedResidual& r) {
  Terms terms;
  int entry = 0;
  for (int row = 0; row < 6; ++row) {
    const double scaled = r.weight_normal * a[row];
    for (int col = row; col < 6; ++col) terms[entry++] = scaled * a[col];
  }
  terms[entry++] = r.weight;
  for (int row = 0; row < 3; ++row) terms[entry++] = r.weight * r.s[row];
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) terms[entry++] = r.weight * r.s[row] * r.s[col];
  }
  terms[entry] = 0.0;
  return terms;
}

void NormalEquations::addAgreement(const WeightedResidual& r) {
  Vector6 a, b;
  a << r.n, r.s.cross(r.n);
  b << r.n_target, r.s.cross(r.n_target);
  const double half = 0.5 * r.weight;
  int entry = 0;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col)
      agreement_[entry++] += half * (a[row] * b[col] + b[row] * a[col]);
  }
}

void NormalEquations::add(const WeightedResidual& r) {
  addAgreement(r);
  Vector6 a, pull;
  a << r.b, r.s.cross(r.b);
  pull << r.e, r.s.cross(r.e);
  const Terms terms = termsOf(a, r);
  const Vector6 force = (r.weight_normal * r.along_normal) * a + (isotropy_ * r.weight) * pull;
  sums_[0] += terms;
  gradient_[0] += force;
  double power = 1.0;
  for (std::size_t k = 1; k <= static_cast<std::size_t>(2 * degree_); ++k) {
    power *= r.tau_s;
    sums_[k] += power * terms;
    if (k <= kDegree) gradient_[k] += power * force;
  }
  normal_weight += r.weight_normal;
  weight += r.weight;
  squared_residuals += r.weight_normal * r.along_normal * r.along_normal;
}

void NormalEquations::add(const NormalEquations& other) {
  for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += other.sums_[k];
  agreement_ += other.agreement_;
  for (std::size_t k = 0; k < gradient_.size(); ++k) gradient_[k] += other.gradient_[k];
  matched += other.matched;
  inliers += other.inliers;
  normal_weight += other.normal_weight;
  weight += other.weight;
  squared_residuals += other.squared_residuals;
}

Matrix6 NormalEquations::symmetric(const double* upper) {
  Matrix6 H;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) H(row, col) = H(col, row) = *upper++;
  }
  return H;
}

Matrix6 NormalEquations::normalPart(int order) const {
  return symmetric(sums_[static_cast<std::size_t>(order)].data());
}

Matrix6 NormalEquations::massPart(int order) const {
  const Terms& terms = sums_[static_cast<std::size_t>(order)];
  const double mass = terms[kUpper];
  const Matrix3 cross = skew(terms.segment<3>(kUpper + 1).matrix());
  Matrix3 inertia;
  int entry = kUpper + 4;
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) inertia(row, col) = inertia(col, row) = terms[entry++];
  }
  // AᵀA = [I, −[s]×; [s]×, |s|² I − s sᵀ].
  Matrix6 H;
  H << mass * Matrix3::Identity(), -cross, cross, inertia.trace() * Matrix3::Identity() - inertia;
  return H;
}

}  // namespace dynemo
