// Oriented planes and their tangent space, as poses have theirs in se3.h.
//
// A plane is the set n · x + d = 0 with unit n; the normal points to the free side, so that the two
// faces of a wall are two planes. Its tangent is [w_1 w_2 δ], radians and metres:
//   (n, d) ⊞ [w δ] = (Exp_n(B(n) w), d + δ)
// with B(n) = orthogonalBasis(n) and Exp_n the exponential of the unit sphere.
#pragma once

#include <cmath>

#include "dynemo/core/se3.h"

namespace dynemo {

struct Plane3 {
  Vector3 normal = Vector3::UnitZ();
  double d_m = 0.0;

  /// Signed distance of a point, positive on the free side [m].
  double distance(const Vector3& p) const { return normal.dot(p) + d_m; }
  Plane3 retract(const Vector3& delta) const;
  bool isFinite() const { return normal.allFinite() && std::isfinite(d_m); }

  static Plane3 through(const Vector3& point, const Vector3& unit_normal) {
    return {unit_normal, -unit_normal.dot(point)};
  }
};

/// The plane of frame b in frame a.
Plane3 operator*(const Pose3& T_a_b, const Plane3& plane_b);

/// Two unit vectors orthogonal to the unit vector u and to each other, a function of u alone.
Eigen::Matrix<double, 3, 2> orthogonalBasis(const Vector3& u);

/// Exp_u(B(u) w): the unit vector at the angle |w| from u in the direction of w.
Vector3 sphereExp(const Vector3& u, const Vector2& w);

struct SphereLog {
  Vector2 w;
  Eigen::Matrix<double, 2, 3> J_w_v;  ///< by v moving on the sphere
};
/// The w with Exp_u(B(u) w) = v, |w| < π: undefined for opposite vectors.
SphereLog sphereLog(const Vector3& u, const Vector3& v);

}  // namespace dynemo
