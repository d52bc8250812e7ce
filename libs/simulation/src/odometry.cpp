#include "dynemo/simulation/odometry.h"

#include <cmath>
#include <numbers>

#include "random.h"

namespace dynemo::simulation {
namespace {

double yawOf(const Pose3& T) { return std::atan2(T.R(1, 0), T.R(0, 0)); }

Vector3 planar(const Pose3& T) { return {T.t.x(), T.t.y(), yawOf(T)}; }

}  // namespace

Pose3 odometryOrigin(const RobotMotion& robot) {
  const Pose3 T = robot.at(0.0);
  return Pose3::fromYawPitchRoll(T.t.x(), T.t.y(), T.t.z(), yawOf(T), 0, 0);
}

PoseOdometry::PoseOdometry(const World& world, const RobotMotion& robot)
    : world_(world), robot_(robot), spec_(world.sensors.odom3d) {
  T_world_base_ = robot.at(0.0);
  T_odom_base_ = odometryOrigin(robot).inverse() * T_world_base_;
  if (!world.sensors.noise) return;
  const Vector3 sigma(spec_.scale_bias_sigma, spec_.yaw_bias_sigma_per_m_rad,
                      spec_.z_bias_sigma_per_m);
  Random random(world.seed, Purpose::kOdom3d);
  for (int i = 0; i < kBiases; ++i) {
    bias_[i] = random.normal(sigma[i]);
    covariance_(6 + i, 6 + i) = sigma[i] * sigma[i];
  }
}

void PoseOdometry::step(std::uint64_t index, double t_s) {
  const Pose3 T_world_next = robot_.at(t_s);
  const Pose3 T_base_next = T_world_base_.inverse() * T_world_next;
  T_world_base_ = T_world_next;
  t_s_ = t_s;
  if (!world_.sensors.noise) {
    T_odom_base_ = (T_odom_base_ * T_base_next).normalized();
    return;
  }
  const double way_m = T_base_next.t.norm(), turn_rad = rotationAngle(T_base_next);
  const auto square = [](double x) { return x * x; };
  Vector6 variance;
  variance.head<2>().setConstant(square(spec_.xy_per_sqrt_m) * way_m +
                                 square(spec_.xy_per_sqrt_rad) * turn_rad);
  variance[2] = square(spec_.z_per_sqrt_m) * way_m;
  variance.segment<2>(3).setConstant(square(spec_.tilt_per_sqrt_m_rad) * way_m);
  variance[5] =
      square(spec_.yaw_per_sqrt_m_rad) * way_m + square(spec_.yaw_per_sqrt_rad_rad) * turn_rad;

  // How each bias moves the step, in the tangent of the next pose.
  Eigen::Matrix<double, 6, kBiases> J = Eigen::Matrix<double, 6, kBiases>::Zero();
  J.block<3, 1>(0, 0) = T_base_next.R.transpose() * T_base_next.t;
  J(5, 1) = way_m;
  J(2, 2) = way_m;
  Random random(world_.seed, Purpose::kOdom3d, index + 1);
  Vector6 error = J * bias_;
  for (int i = 0; i < 6; ++i) error[i] += random.normal(std::sqrt(variance[i]));
  T_odom_base_ = (T_odom_base_ * T_base_next).retract(error);

  State F = State::Identity();
  F.block<6, 6>(0, 0) = composeJacobianLeft(T_base_next);
  F.block<6, kBiases>(0, 6) = J;
  covariance_ = F * covariance_ * F.transpose();
  covariance_.diagonal().head<6>() += variance;
}

PoseOdometry::Estimate PoseOdometry::at(std::uint64_t index, double t_s) {
  if (t_s > t_s_) step(index, t_s);
  Estimate estimate{T_odom_base_, covariance_.block<6, 6>(0, 0)};
  if (!world_.sensors.noise || index == 0) return estimate;
  Random jitter(world_.seed, Purpose::kOdom3d, ~index);
  Vector6 error;
  for (int i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? spec_.jitter_m : spec_.jitter_rad;
    error[i] = jitter.normal(sigma);
    estimate.covariance(i, i) += sigma * sigma;
  }
  estimate.T_odom_base = T_odom_base_.retract(error);
  return estimate;
}

WheelOdometry::WheelOdometry(const World& world, const RobotMotion& robot)
    : world_(world), robot_(robot), spec_(world.sensors.odom2d), truth_(planar(robot.at(0.0))) {
  if (!world.sensors.noise) return;
  Random random(world.seed, Purpose::kOdom2d);
  scale_bias_ = random.normal(spec_.scale_bias_sigma);
  yaw_bias_ = random.normal(spec_.yaw_bias_sigma_per_m_rad);
}

Vector3 WheelOdometry::at(std::uint64_t index, double t_s) {
  if (t_s <= t_s_) return pose_;
  t_s_ = t_s;
  const Vector3 next = planar(robot_.at(t_s));
  const Eigen::Rotation2Dd R_base_world(-truth_[2]);
  Vector2 way = R_base_world * (next.head<2>() - truth_.head<2>());
  double turn_rad = std::remainder(next[2] - truth_[2], 2.0 * std::numbers::pi);
  truth_ = next;
  if (world_.sensors.noise) {
    Random random(world_.seed, Purpose::kOdom2d, index + 1);
    const double way_m = way.norm(), turned_rad = std::abs(turn_rad);
    const double sigma_m = spec_.xy_per_sqrt_m * std::sqrt(way_m);
    way = (1.0 + scale_bias_) * way + Vector2(random.normal(sigma_m), random.normal(0.3 * sigma_m));
    turn_rad += yaw_bias_ * way_m + random.normal(spec_.yaw_per_sqrt_m_rad * std::sqrt(way_m)) +
                random.normal(spec_.yaw_per_sqrt_rad_rad * std::sqrt(turned_rad));
  }
  pose_.head<2>() += Eigen::Rotation2Dd(pose_[2]) * way;
  pose_[2] = std::remainder(pose_[2] + turn_rad, 2.0 * std::numbers::pi);
  return pose_;
}

}  // namespace dynemo::simulation
