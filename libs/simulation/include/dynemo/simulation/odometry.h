// Odometry that drifts: a random walk with distance and turning, and its honest covariance.
#pragma once

#include "dynemo/core/se3.h"
#include "dynemo/simulation/robot_motion.h"
#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

/// T_world_odom: the base's position at the start, with its yaw and levelled.
Pose3 odometryOrigin(const RobotMotion& robot);

/// Poses of the base in the odometry frame, at times that ascend. At the start it is the truth.
class PoseOdometry {
 public:
  PoseOdometry(const World& world, const RobotMotion& robot);

  struct Estimate {
    Pose3 T_odom_base;
    /// Of the right tangent of T_odom_base; accumulated since the start, constant biases included.
    Matrix6 covariance;
  };
  Estimate at(std::uint64_t index, double t_s);

 private:
  static constexpr int kBiases = 3;  ///< scale, yaw per metre, z per metre
  using State = Eigen::Matrix<double, 6 + kBiases, 6 + kBiases>;
  void step(std::uint64_t index, double t_s);

  const World& world_;
  const RobotMotion& robot_;
  PoseOdometrySpec spec_;
  Vector3 bias_ = Vector3::Zero();
  double t_s_ = 0.0;
  Pose3 T_world_base_, T_odom_base_;
  State covariance_ = State::Zero();
};

/// x, y, yaw of the base as the wheels count them, at times that ascend; the origin at the start.
class WheelOdometry {
 public:
  WheelOdometry(const World& world, const RobotMotion& robot);
  /// x y [m] yaw [rad].
  Vector3 at(std::uint64_t index, double t_s);

 private:
  const World& world_;
  const RobotMotion& robot_;
  WheelOdometrySpec spec_;
  double scale_bias_ = 0.0, yaw_bias_ = 0.0, t_s_ = 0.0;
  Vector3 truth_, pose_ = Vector3::Zero();
};

}  // namespace dynemo::simulation
