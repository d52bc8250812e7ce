// Rigid-body poses and their tangent space, as used by every stage.
//
// T_a_b is the pose of frame b in frame a: p_a = T_a_b * p_b. Tangent vectors are
// [x y z rx ry rz] in metres and radians, applied on the right and decoupled:
//   T ⊞ d = (t + R d_t, R Exp(d_r)),   T_b ⊟ T_a = (R_aᵀ (t_b − t_a), Log(R_aᵀ R_b)).
// This is the pseudo exponential that MRPT's Lie::SE<3> uses too, not the exponential of the group.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace dynemo {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// [v]ₓ, so that [v]ₓ w = v × w.
Matrix3 skew(const Vector3& v);

/// Rotation of angle |w| about w [rad].
Matrix3 expSO3(const Vector3& w);

/// Rotation vector of R, |w| ≤ π [rad]; stable near 0 and near π.
Vector3 logSO3(const Matrix3& R);

/// Right Jacobian: Exp(w + dw) ≈ Exp(w) Exp(Jr(w) dw).
Matrix3 rightJacobianSO3(const Vector3& w);

/// Inverse of the right Jacobian: Log(Exp(w) Exp(d)) ≈ w + Jr⁻¹(w) d.
Matrix3 rightJacobianInverseSO3(const Vector3& w);

/// The rotation closest to M in the Frobenius norm.
Matrix3 nearestRotation(const Matrix3& M);

/// An element of SE(3): rotation R and translation t of one frame in another.
struct Pose3 {
  Matrix3 R = Matrix3::Identity();
  Vector3 t = Vector3::Zero();

  Pose3() = default;
  Pose3(const Matrix3& rotation, const Vector3& translation) : R(rotation), t(translation) {}
  Pose3(const Eigen::Quaterniond& q, const Vector3& translation)
      : R(q.normalized().toRotationMatrix()), t(translation) {}

  static Pose3 translation(const Vector3& t) { return {Matrix3::Identity(), t}; }
  static Pose3 translation(double x, double y, double z) { return translation(Vector3(x, y, z)); }
  /// R = Rz(yaw) Ry(pitch) Rx(roll), as mrpt::poses::CPose3D [m, rad].
  static Pose3 fromYawPitchRoll(double x, double y, double z, double yaw, double pitch,
                                double roll);

  Pose3 operator*(const Pose3& T_b_c) const { return {R * T_b_c.R, R * T_b_c.t + t}; }
  Vector3 operator*(const Vector3& p_b) const { return R * p_b + t; }
  Pose3 inverse() const { return {R.transpose(), -(R.transpose() * t)}; }

  /// Unit quaternion with w ≥ 0.
  Eigen::Quaterniond quaternion() const;
  /// T ⊞ d; the rotation is re-orthonormalised so that long chains stay in SO(3).
  Pose3 retract(const Vector6& d) const;
  /// The same pose with its rotation projected back onto SO(3).
  Pose3 normalized() const;
  bool isFinite() const { return R.allFinite() && t.allFinite(); }
};

/// T_b ⊟ T_a: the tangent d with T_a ⊞ d = T_b.
Vector6 local(const Pose3& T_a, const Pose3& T_b);

/// Rotation angle of T in [0, π] [rad].
double rotationAngle(const Pose3& T);

/// Between a and b at fraction s ∈ [0, 1]: linear translation, constant-rate rotation.
Pose3 interpolate(const Pose3& T_a, const Pose3& T_b, double s);

/// How a perturbation of T moves T·T_c: d(T T_c) = adjointRight(T_c) · dT, for right tangents.
/// For T ⊞ d: (T ⊞ d) T_c = (T T_c) ⊞ (A d) to first order.
Matrix6 composeJacobianLeft(const Pose3& T_c);

/// How a perturbation of T_c moves T·T_c (the identity in this convention except that translation
/// is in T_c's own axes): d(T T_c) = composeJacobianRight() · dT_c = dT_c.
inline Matrix6 composeJacobianRight() { return Matrix6::Identity(); }

/// Covariance of a pose's right tangent after re-expressing the translation part in the parent's
/// axes, and back.
Matrix6 covarianceTranslationToParent(const Matrix6& tangent_cov, const Matrix3& R);
Matrix6 covarianceTranslationToLocal(const Matrix6& parent_cov, const Matrix3& R);

}  // namespace dynemo
