#include "dynemo/odometry/body_twist.h"

namespace dynemo {

Pose3 moved(const BodyTwist& twist, double dt_s) {
  const Vector3 w = twist.angular_rad_s * dt_s;
  // The left Jacobian is the right one of the opposite rotation.
  return {expSO3(w), rightJacobianSO3(-w) * (twist.linear_m_s * dt_s)};
}

BodyTwist twistOf(const Pose3& T_b0_b1, double dt_s) {
  const Vector3 w = logSO3(T_b0_b1.R);
  return {rightJacobianInverseSO3(-w) * T_b0_b1.t / dt_s, w / dt_s};
}

}  // namespace dynemo
