// Motion of the base during one sweep.
#pragma once

#include "dynemo/core/se3.h"

namespace dynemo {

/// Velocity of the base frame, or its rate of change, expressed in the base frame.
struct BodyTwist {
  Vector3 linear_m_s = Vector3::Zero();
  Vector3 angular_rad_s = Vector3::Zero();

  Vector6 vector() const;
  static BodyTwist fromVector(const Vector6& v);
};

/// T_mid_base(τ) = Exp(τ ξ + τ²/2 α) of SE(3), τ seconds after the reference time (the middle of
/// the sweep): constant acceleration to the second order.
struct SweepMotion {
  BodyTwist twist;         ///< ξ
  BodyTwist acceleration;  ///< α, per second

  Pose3 at(double tau_s) const;
};

/// The constant twist that makes T_b0_b1 in dt_s ≠ 0; rotation angle below π.
BodyTwist twistOf(const Pose3& T_b0_b1, double dt_s);

/// SweepMotion::at() for many points, in single precision: Exp as its power series up to the third
/// power, whose relative error |ω τ|⁴/24 is 4e-6 at 0.1 rad.
class PointCarrier {
 public:
  /// The motion of a frame fixed to the base at `T_base_sensor`, for points given in that frame.
  explicit PointCarrier(const SweepMotion& motion, const Pose3& T_base_sensor = Pose3());

  /// Coordinates in the frame at the reference time of a point given in the frame at τ.
  Eigen::Vector3f toReference(float tau_s, const Eigen::Vector3f& p) const {
    const float half_tau = 0.5F * tau_s;
    const Eigen::Vector3f w = angular_ + half_tau * angular_rate_;
    const Eigen::Vector3f first = w.cross(p) + linear_ + half_tau * linear_rate_;
    const Eigen::Vector3f second = w.cross(first);
    return p + tau_s * (first + half_tau * (second + (tau_s / 3.0F) * w.cross(second)));
  }

 private:
  Eigen::Vector3f linear_, angular_, linear_rate_, angular_rate_;
};

}  // namespace dynemo
