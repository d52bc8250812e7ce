#include "action_odometry.h"

#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/poses/CPosePDFGaussianInf.h>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {
namespace {

using mrpt::obs::CActionRobotMovement2D;
using mrpt::obs::CActionRobotMovement3D;

struct Increment {
  Pose3 T_prev_next;
  std::optional<Matrix6> covariance;  ///< of the right tangent
};

std::optional<Matrix6> tangentCovariance(const Pose3& T, const mrpt::math::CMatrixDouble66& ypr) {
  const Matrix6 cov = covarianceFromMrpt(T, ypr);
  if (!cov.allFinite() || cov.isZero(0.0)) return std::nullopt;
  return cov;
}

std::optional<Matrix6> planarCovariance(const mrpt::poses::CPosePDF& pdf, const Pose3& T) {
  using namespace mrpt::poses;
  // MRPT re-creates sets of particles by random draws on reading: not reproducible, so not used.
  if (!IS_CLASS(pdf, CPosePDFGaussian) && !IS_CLASS(pdf, CPosePDFGaussianInf)) return std::nullopt;
  const mrpt::math::CMatrixDouble33 xyphi = pdf.getCovariance();
  mrpt::math::CMatrixDouble66 cov;
  cov.setZero();
  const int index[] = {0, 1, 3};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) cov(index[r], index[c]) = xyphi(r, c);
  return tangentCovariance(T, cov);
}

Increment increment(const CActionRobotMovement2D& a) {
  Increment out;
  mrpt::poses::CPose2D mean = a.rawOdometryIncrementReading;
  if (a.estimationMethod != CActionRobotMovement2D::emOdometry && a.poseChange)
    mean = a.poseChange->getMeanVal();
  out.T_prev_next = fromMrpt(mrpt::poses::CPose3D(mean));
  if (a.poseChange) out.covariance = planarCovariance(*a.poseChange, out.T_prev_next);
  return out;
}

Increment increment(const CActionRobotMovement3D& a) {
  Increment out;
  out.T_prev_next = fromMrpt(a.poseChange.mean);
  out.covariance = tangentCovariance(out.T_prev_next, a.poseChange.cov);
  return out;
}

/// The increment of the first odometry among the actions, else the first of another method.
std::optional<Increment> bestIncrement(const mrpt::obs::CActionCollection& actions) {
  std::optional<Increment> other;
  for (const auto& holder : actions) {
    const mrpt::obs::CAction* action = holder.get_ptr().get();
    if (const auto* a3 = dynamic_cast<const CActionRobotMovement3D*>(action)) {
      if (a3->estimationMethod == CActionRobotMovement3D::emOdometry) return increment(*a3);
      if (!other) other = increment(*a3);
    } else if (const auto* a2 = dynamic_cast<const CActionRobotMovement2D*>(action)) {
      if (a2->estimationMethod == CActionRobotMovement2D::emOdometry) return increment(*a2);
      if (!other) other = increment(*a2);
    }
  }
  return other;
}

}  // namespace

bool ActionOdometry::apply(const mrpt::obs::CActionCollection& actions, WarningCounter& warnings) {
  const auto step = bestIncrement(actions);
  if (!step) return false;
  if (!isPlausible(step->T_prev_next)) {
    warnings.count("odometry action that is not plausible dropped");
    return false;
  }
  state_.T_odom_base = (state_.T_odom_base * step->T_prev_next).normalized();
  if (step->covariance && state_.accumulated_covariance) {
    const Matrix6 A = composeJacobianLeft(step->T_prev_next);
    state_.accumulated_covariance =
        A * *state_.accumulated_covariance * A.transpose() + *step->covariance;
  } else {
    state_.accumulated_covariance.reset();
  }
  return true;
}

}  // namespace dynemo
