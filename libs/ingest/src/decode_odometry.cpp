// CObservationRobotPose and CObservationOdometry: cumulative poses of the base in the odometry
// frame.
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {

Expected<OdometryState, DecodeFailure> decodeRobotPose(mrpt::obs::CObservation& observation,
                                                       const DecodeContext&) {
  const auto& o = dynamic_cast<const mrpt::obs::CObservationRobotPose&>(observation);
  OdometryState state;
  state.T_odom_base = fromMrpt(o.pose.mean);
  if (!isPlausible(state.T_odom_base)) return make_unexpected("the pose is not plausible");
  state.T_odom_base = state.T_odom_base.normalized();
  const Matrix6 cov = covarianceFromMrpt(state.T_odom_base, o.pose.cov);
  // A zero matrix is MRPT's way to say that there is none.
  if (cov.allFinite() && !cov.isZero(0.0)) state.accumulated_covariance = cov;
  return state;
}

Expected<OdometryState, DecodeFailure> decodeOdometry2D(mrpt::obs::CObservation& observation,
                                                        const DecodeContext&) {
  const auto& o = dynamic_cast<const mrpt::obs::CObservationOdometry&>(observation);
  OdometryState state;
  state.T_odom_base = fromMrpt(mrpt::poses::CPose3D(o.odometry));
  if (!isPlausible(state.T_odom_base)) return make_unexpected("the pose is not plausible");
  return state;
}

}  // namespace dynemo
