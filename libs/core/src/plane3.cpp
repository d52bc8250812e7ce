#include "dynemo/core/plane3.h"

#include <cmath>

namespace dynemo {

Plane3 Plane3::retract(const Vector3& delta) const {
  return {sphereExp(normal, delta.head<2>()), d_m + delta.z()};
}

Plane3 operator*(const Pose3& T_a_b, const Plane3& plane_b) {
  const Vector3 n_a = T_a_b.R * plane_b.normal;
  return {n_a, plane_b.d_m - n_a.dot(T_a_b.t)};
}

Eigen::Matrix<double, 3, 2> orthogonalBasis(const Vector3& u) {
  const Vector3 least = std::abs(u.x()) < 0.6 ? Vector3::UnitX() : Vector3::UnitY();
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = u.cross(least).normalized();
  B.col(1) = u.cross(B.col(0));
  return B;
}

Vector3 sphereExp(const Vector3& u, const Vector2& w) {
  const double angle = w.norm();
  const double sinc = angle < 1e-8 ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  return (std::cos(angle) * u + sinc * (orthogonalBasis(u) * w)).normalized();
}

SphereLog sphereLog(const Vector3& u, const Vector3& v) {
  const Eigen::Matrix<double, 2, 3> BT = orthogonalBasis(u).transpose();
  const Vector2 s = BT * v;  // of length sin θ
  const double sine = s.norm(), angle = std::atan2(sine, u.dot(v));
  // f = θ / sin θ and g = f'(θ) / sin θ, by their series near 0.
  const bool small = sine < 1e-4 && angle < 1.0;
  const double f = small ? 1.0 + angle * angle / 6.0 : angle / sine;
  const double g = small ? 1.0 / 3.0 + angle * angle * (2.0 / 15.0)
                         : (sine - angle * std::cos(angle)) / (sine * sine * sine);
  return {f * s, f * BT - g * s * u.transpose()};
}

}  // namespace dynemo
