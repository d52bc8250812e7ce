#include "dynemo/core/mrpt_conversions.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

/// MRPT counts 100 ns ticks since 1601-01-01; the UNIX epoch is this many ticks later.
constexpr std::int64_t kUnixEpochTicks = 116444736LL * 1000000000LL;

/// d(x y z yaw pitch roll) / d(right tangent) at T.
Matrix6 yprJacobian(const Pose3& T) {
  double yaw = 0, pitch = 0, roll = 0;
  toMrpt(T).getYawPitchRoll(yaw, pitch, roll);
  double cp = std::cos(pitch);
  if (std::abs(cp) < 1e-6) cp = std::copysign(1e-6, cp);
  const double tp = std::sin(pitch) / cp, sr = std::sin(roll), cr = std::cos(roll);
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = T.R;
  // Body angular rates to yaw, pitch, roll rates for R = Rz Ry Rx.
  J.row(3).tail<3>() << 0, sr / cp, cr / cp;
  J.row(4).tail<3>() << 0, cr, -sr;
  J.row(5).tail<3>() << 1, sr * tp, cr * tp;
  return J;
}

}  // namespace

mrpt::poses::CPose3D toMrpt(const Pose3& T) {
  mrpt::math::CMatrixDouble33 R;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) R(r, c) = T.R(r, c);
  return mrpt::poses::CPose3D(R, mrpt::math::CVectorFixedDouble<3>({T.t.x(), T.t.y(), T.t.z()}));
}

Pose3 fromMrpt(const mrpt::poses::CPose3D& T) {
  Pose3 out;
  const auto& R = T.getRotationMatrix();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.R(r, c) = R(r, c);
  out.t = Vector3(T.x(), T.y(), T.z());
  return out;
}

mrpt::Clock::time_point toMrpt(Stamp stamp) {
  return mrpt::Clock::time_point(mrpt::Clock::duration(stamp.ns / 100 + kUnixEpochTicks));
}

Stamp fromMrpt(mrpt::Clock::time_point time) {
  return {(time.time_since_epoch().count() - kUnixEpochTicks) * 100};
}

mrpt::math::CMatrixDouble66 covarianceToMrpt(const Pose3& T, const Matrix6& tangent_cov) {
  const Matrix6 J = yprJacobian(T);
  const Matrix6 cov = J * tangent_cov * J.transpose();
  mrpt::math::CMatrixDouble66 out;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) out(r, c) = cov(r, c);
  return out;
}

Matrix6 covarianceFromMrpt(const Pose3& T, const mrpt::math::CMatrixDouble66& ypr_cov) {
  Matrix6 cov;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) cov(r, c) = ypr_cov(r, c);
  const Matrix6 J_inv = yprJacobian(T).inverse();
  const Matrix6 out = J_inv * cov * J_inv.transpose();
  return 0.5 * (out + out.transpose());
}

std::string mrptReason(const std::exception& error) {
  const std::string text = error.what(), key = "Message:";
  const std::size_t begin = text.find(key);
  if (begin == std::string::npos) return text.substr(0, text.find('\n'));
  const std::size_t from = std::min(text.find_first_not_of(' ', begin + key.size()), text.size());
  return text.substr(from, text.find('\n', from) - from);
}

mrpt::poses::CPose3DPDFGaussian toMrptGaussian(const Pose3& T, const Matrix6& tangent_cov) {
  return {toMrpt(T), covarianceToMrpt(T, tangent_cov)};
}

}  // namespace dynemo
