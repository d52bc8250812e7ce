// The one place where poses, covariances and stamps cross between this project's conventions and
// MRPT's.
//
// MRPT stores covariances as (x, y, z, yaw, pitch, roll) with the translation in the parent's axes;
// ours belong to the right tangent [x y z rx ry rz] of se3.h.
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPose3DPDFGaussianInf.h>

#include <exception>
#include <string>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

mrpt::poses::CPose3D toMrpt(const Pose3& T);
Pose3 fromMrpt(const mrpt::poses::CPose3D& T);

mrpt::Clock::time_point toMrpt(Stamp stamp);
Stamp fromMrpt(mrpt::Clock::time_point time);

/// Covariance of (x, y, z, yaw, pitch, roll) at pose T for a right-tangent covariance, and back. At
/// |pitch| = 90° the angles are singular; the pitch is then moved off by 1e-6 rad.
mrpt::math::CMatrixDouble66 covarianceToMrpt(const Pose3& T, const Matrix6& tangent_cov);
Matrix6 covarianceFromMrpt(const Pose3& T, const mrpt::math::CMatrixDouble66& ypr_cov);

/// Why MRPT threw, in one line: its messages have a heading above and a stack of calls below.
std::string mrptReason(const std::exception& error);

mrpt::poses::CPose3DPDFGaussian toMrptGaussian(const Pose3& T, const Matrix6& tangent_cov);

}  // namespace dynemo
