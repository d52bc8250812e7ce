#include "dynemo/odometry/sweep_motion.h"

namespace dynemo {
namespace {

/// The twist of a frame at T_base_sensor on the body: adjoint of T_base_sensor⁻¹.
BodyTwist seenFrom(const Pose3& T_base_sensor, const BodyTwist& twist) {
  const Matrix3 R_sensor_base = T_base_sensor.R.transpose();
  return {R_sensor_base * (twist.linear_m_s + twist.angular_rad_s.cross(T_base_sensor.t)),
          R_sensor_base * twist.angular_rad_s};
}

}  // namespace

Vector6 BodyTwist::vector() const {
  Vector6 v;
  v << linear_m_s, angular_rad_s;
  return v;
}

BodyTwist BodyTwist::fromVector(const Vector6& v) { return {v.head<3>(), v.tail<3>()}; }

Pose3 SweepMotion::at(double tau_s) const {
  const Vector6 d = tau_s * (twist.vector() + 0.5 * tau_s * acceleration.vector());
  // The left Jacobian is the right one of the opposite rotation.
  return {expSO3(d.tail<3>()), rightJacobianSO3(-d.tail<3>()) * d.head<3>()};
}

BodyTwist twistOf(const Pose3& T_b0_b1, double dt_s) {
  const Vector3 w = logSO3(T_b0_b1.R);
  return {rightJacobianInverseSO3(-w) * T_b0_b1.t / dt_s, w / dt_s};
}

PointCarrier::PointCarrier(const SweepMotion& motion, const Pose3& T_base_sensor) {
  const BodyTwist twist = seenFrom(T_base_sensor, motion.twist);
  const BodyTwist rate = seenFrom(T_base_sensor, motion.acceleration);
  linear_ = twist.linear_m_s.cast<float>();
  angular_ = twist.angular_rad_s.cast<float>();
  linear_rate_ = rate.linear_m_s.cast<float>();
  angular_rate_ = rate.angular_rad_s.cast<float>();
}

}  // namespace dynemo
