#include "stamp_compensation.h"

namespace dynemo {

std::optional<Pose3> motionFromFrame(const SensorFrame& frame, Stamp other,
                                     const std::optional<OdometryState>& odometry_other) {
  if (other == frame.stamp) return Pose3();
  if (!frame.odometry || !odometry_other) return std::nullopt;
  const Pose3 T_frame_other = frame.odometry->T_odom_base.inverse() * odometry_other->T_odom_base;
  if (!T_frame_other.isFinite()) return std::nullopt;
  return T_frame_other;
}

}  // namespace dynemo
