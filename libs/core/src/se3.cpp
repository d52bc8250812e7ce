#include "dynemo/core/se3.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {
constexpr double kSmallAngle = 1e-5;  // below it the series is exact to double precision
}

Matrix3 skew(const Vector3& v) {
  Matrix3 S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Matrix3 expSO3(const Vector3& w) {
  const double theta2 = w.squaredNorm();
  const double theta = std::sqrt(theta2);
  const Matrix3 W = skew(w);
  const double a = theta < kSmallAngle ? 1.0 - theta2 / 6.0 : std::sin(theta) / theta;
  const double b = theta < kSmallAngle ? 0.5 - theta2 / 24.0 : (1.0 - std::cos(theta)) / theta2;
  return Matrix3::Identity() + a * W + b * (W * W);
}

Vector3 logSO3(const Matrix3& R) {
  // Through the quaternion: well conditioned at every angle, also near π.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sin_half = q.vec().norm();
  if (sin_half < kSmallAngle) {
    const double w2 = q.w() * q.w();
    return (2.0 / q.w() - 2.0 / 3.0 * sin_half * sin_half / (w2 * q.w())) * q.vec();
  }
  return 2.0 * std::atan2(sin_half, q.w()) / sin_half * q.vec();
}

Matrix3 rightJacobianSO3(const Vector3& w) {
  const double theta2 = w.squaredNorm();
  const double theta = std::sqrt(theta2);
  const Matrix3 W = skew(w);
  const double a = theta < kSmallAngle ? 0.5 - theta2 / 24.0 : (1.0 - std::cos(theta)) / theta2;
  const double b = theta < kSmallAngle ? 1.0 / 6.0 - theta2 / 120.0
                                       : (theta - std::sin(theta)) / (theta2 * theta);
  return Matrix3::Identity() - a * W + b * (W * W);
}

Matrix3 rightJacobianInverseSO3(const Vector3& w) {
  const double theta2 = w.squaredNorm();
  const double theta = std::sqrt(theta2);
  const Matrix3 W = skew(w);
  // 1/θ² − (1+cos θ)/(2 θ sin θ) = (1 − (θ/2)·cot(θ/2))/θ², finite at π.
  const double b = theta < 1e-3 ? 1.0 / 12.0 + theta2 / 720.0
                                : (1.0 - 0.5 * theta / std::tan(0.5 * theta)) / theta2;
  return Matrix3::Identity() + 0.5 * W + b * (W * W);
}

Matrix3 nearestRotation(const Matrix3& M) {
  const Eigen::JacobiSVD<Matrix3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * Vector3(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
}

Pose3 Pose3::fromYawPitchRoll(double x, double y, double z, double yaw, double pitch, double roll) {
  const Matrix3 R =
      (Eigen::AngleAxisd(yaw, Vector3::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3::UnitY()) *
       Eigen::AngleAxisd(roll, Vector3::UnitX()))
          .toRotationMatrix();
  return {R, Vector3(x, y, z)};
}

Eigen::Quaterniond Pose3::quaternion() const {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q;
}

Pose3 Pose3::retract(const Vector6& d) const {
  return Pose3(R * expSO3(d.tail<3>()), t + R * d.head<3>()).normalized();
}

Pose3 Pose3::normalized() const {
  // One Newton step towards the polar factor: exact to second order for the drift of a product.
  return {0.5 * R * (3.0 * Matrix3::Identity() - R.transpose() * R), t};
}

Vector6 local(const Pose3& T_a, const Pose3& T_b) {
  Vector6 d;
  d.head<3>() = T_a.R.transpose() * (T_b.t - T_a.t);
  d.tail<3>() = logSO3(T_a.R.transpose() * T_b.R);
  return d;
}

double rotationAngle(const Pose3& T) { return logSO3(T.R).norm(); }

Pose3 interpolate(const Pose3& T_a, const Pose3& T_b, double s) {
  const Vector3 w = logSO3(T_a.R.transpose() * T_b.R);
  return {T_a.R * expSO3(s * w), (1.0 - s) * T_a.t + s * T_b.t};
}

Matrix6 composeJacobianLeft(const Pose3& T_c) {
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = T_c.R.transpose();
  A.topRightCorner<3, 3>() = -T_c.R.transpose() * skew(T_c.t);
  A.bottomRightCorner<3, 3>() = T_c.R.transpose();
  return A;
}

Matrix6 covarianceTranslationToParent(const Matrix6& tangent_cov, const Matrix3& R) {
  Matrix6 A = Matrix6::Identity();
  A.topLeftCorner<3, 3>() = R;
  return A * tangent_cov * A.transpose();
}

Matrix6 covarianceTranslationToLocal(const Matrix6& parent_cov, const Matrix3& R) {
  return covarianceTranslationToParent(parent_cov, R.transpose());
}

}  // namespace dynemo
