#include "synthetic_world.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace dynemo::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Of the first stamp, so that stamps are as large as in real logs.
constexpr std::int64_t kEpoch_ns = 1'700'000'000'000'000'000;

/// Slab test; the near face from outside, the far face from inside.
double castBox(const Box& box, const Vector3& origin, const Vector3& direction) {
  const Vector3 o = box.T_world_box.R.transpose() * (origin - box.T_world_box.t);
  const Vector3 d = box.T_world_box.R.transpose() * direction;
  double enter = -kInfinity, leave = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-box.half_size_m[axis] - o[axis]) / d[axis];
    const double b = (box.half_size_m[axis] - o[axis]) / d[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter <= leave) || leave <= 0.0) return kInfinity;
  return enter > 0.0 ? enter : leave;
}

Box box(double x, double y, double z, double yaw_rad, double sx, double sy, double sz) {
  return {Pose3::fromYawPitchRoll(x, y, z, yaw_rad, 0, 0), 0.5 * Vector3(sx, sy, sz)};
}

}  // namespace

double World::cast(const Vector3& origin, const Vector3& direction) const {
  double nearest = kInfinity;
  for (const Box& b : boxes) nearest = std::min(nearest, castBox(b, origin, direction));
  return nearest;
}

World furnishedRoom() {
  return {{box(0, 0, 1.5, 0, 12, 9, 3), box(1.5, 1.8, 1.5, 0, 0.12, 5.4, 3),
           box(-4, 3, 0.5, 0.3, 1.2, 0.6, 1), box(-3, -3.5, 0.4, -0.2, 1.6, 0.8, 0.8),
           box(4, -3, 0.6, 0.7, 0.7, 0.7, 1.2), box(4.5, 2.5, 0.9, 0.1, 0.5, 1.5, 1.8),
           box(-5.6, 0, 1, 0, 0.4, 2, 2), box(0.2, -4.2, 1, 0, 1.5, 0.4, 2),
           box(3, 4, 0.35, 1.1, 0.5, 0.5, 0.7)}};
}

World endlessCorridor() { return {{box(0, 0, 1.25, 0, 4000, 2.4, 2.5)}}; }

Trajectory handHeldWalk() {
  return [](double t) {
    const double angle = 0.3 * t;
    const double shake = 2 * kPi * 2 * t;
    const double amplitude_rad = 4.0 * kPi / 180.0;
    return Pose3::fromYawPitchRoll(
        -0.5 + 3.2 * std::cos(angle), -2.2 + 1.1 * std::sin(angle), 1.25 + 0.04 * std::sin(shake),
        angle + kPi / 2 + 0.1 * std::sin(2.1 * t), amplitude_rad * std::sin(shake + 0.7),
        amplitude_rad * std::sin(shake + 2.0));
  };
}

Trajectory wheeledDrive() {
  return [](double t) {
    return Pose3::fromYawPitchRoll(-4 + 0.6 * t, -1.5 + 0.8 * std::sin(0.7 * t), 0.6,
                                   std::atan2(0.56 * std::cos(0.7 * t), 0.6), 0, 0);
  };
}

Trajectory atRest() {
  return [](double) { return Pose3::fromYawPitchRoll(-1, -1, 0.6, 0.4, 0, 0); };
}

Trajectory straight(double speed_m_s) {
  return [=](double t) { return Pose3::translation(speed_m_s * t, 0.2, 0.8); };
}

Scan sweep(const World& world, const LidarModel& lidar, const Trajectory& T_world_base,
           double time_s, std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, lidar.sigma_m);
  Scan scan;
  scan.stamp.ns = kEpoch_ns + std::llround(time_s * 1e9);
  scan.T_base_lidar = lidar.T_base_lidar;
  for (int column = 0; column < lidar.columns; ++column) {
    const double turned = (column + 0.5) / lidar.columns;
    const Pose3 T_world_lidar = T_world_base(time_s + turned * lidar.sweep_s) * lidar.T_base_lidar;
    const double azimuth = (2.0 * turned - 1.0) * kPi;
    for (int row = 0; row < lidar.rows; ++row) {
      const double elevation = (0.5 - (row + 0.5) / lidar.rows) * lidar.vertical_fov_rad;
      const Vector3 ray(std::cos(elevation) * std::cos(azimuth),
                        std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double range = world.cast(T_world_lidar.t, T_world_lidar.R * ray);
      if (range > lidar.max_range_m) continue;
      scan.cloud.points.push_back((ray * (range + noise(random))).cast<float>());
      if (lidar.sweep_s > 0.0) {
        scan.cloud.time_offset_s.push_back(static_cast<float>(turned * lidar.sweep_s));
      }
    }
  }
  return scan;
}

double absoluteTrajectoryError(const std::vector<Pose3>& truth,
                               const std::vector<Pose3>& estimate) {
  const auto n = static_cast<Eigen::Index>(truth.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = estimate[static_cast<std::size_t>(i)].t;
    b.col(i) = truth[static_cast<std::size_t>(i)].t;
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3Xd aligned =
      (T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>();
  return std::sqrt((aligned - b).colwise().squaredNorm().mean());
}

}  // namespace dynemo::test
