#pragma once

#include "dynemo/core/se3.h"

namespace dynemo {

/// Covariance of the right tangent of T_prev_base from those of both poses in a common frame, taken
/// as independent.
inline Matrix6 relativeCovariance(const Pose3& T_prev_base, const Matrix6& cov_prev,
                                  const Matrix6& cov_base) {
  const Matrix6 J = -composeJacobianLeft(T_prev_base);
  return J * cov_prev * J.transpose() + cov_base;
}

}  // namespace dynemo
