// Motion at constant velocity during a short time.
#pragma once

#include "dynemo/core/se3.h"

namespace dynemo {

/// Velocity of the base frame, expressed in the base frame.
struct BodyTwist {
  Vector3 linear_m_s = Vector3::Zero();
  Vector3 angular_rad_s = Vector3::Zero();
};

/// T_b0_b1: where the base is after dt_s at constant twist, Exp(dt ξ) of SE(3).
Pose3 moved(const BodyTwist& twist, double dt_s);

/// The constant twist that makes T_b0_b1 in dt_s ≠ 0; rotation angle below π.
BodyTwist twistOf(const Pose3& T_b0_b1, double dt_s);

/// Coordinates, in the base frame at time 0, of a point given in the base frame at dt_s: Exp(dt ξ)
/// p as its power series up to dt³, whose relative error |ω dt|⁴/24 is 4e-6 at 0.1 rad. Much
/// cheaper than the closed form.
template <class Scalar>
Eigen::Matrix<Scalar, 3, 1> carriedToReference(const Eigen::Matrix<Scalar, 3, 1>& linear_m_s,
                                               const Eigen::Matrix<Scalar, 3, 1>& angular_rad_s,
                                               Scalar dt_s, const Eigen::Matrix<Scalar, 3, 1>& p) {
  using Vec = Eigen::Matrix<Scalar, 3, 1>;
  const Vec velocity = angular_rad_s.cross(p) + linear_m_s;
  const Vec acceleration = angular_rad_s.cross(velocity);
  const Vec jerk = angular_rad_s.cross(acceleration);
  return p + dt_s * (velocity + dt_s * (Scalar(0.5) * acceleration + (dt_s / Scalar(6)) * jerk));
}

}  // namespace dynemo
