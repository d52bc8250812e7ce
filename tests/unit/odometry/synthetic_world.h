// Scans of a made-up place by a turning LiDAR on a moving base, with the truth.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "dynemo/core/point_cloud.h"
#include "dynemo/core/se3.h"

namespace dynemo::test {

/// A box with its frame in the middle. From inside (a room) or outside (furniture).
struct Box {
  Pose3 T_world_box;
  Vector3 half_size_m;

  /// Along the world's axes.
  static Box between(const Vector3& min, const Vector3& max) {
    return {Pose3::translation(0.5 * (min + max)), 0.5 * (max - min)};
  }
};

struct World {
  std::vector<Box> boxes;

  /// Distance along the unit ray to the first surface; infinite when there is none.
  double cast(const Vector3& origin, const Vector3& direction) const;
};

/// 12 × 9 × 3 m with furniture and an inner wall of 12 cm.
World furnishedRoom();
/// Walls, floor and ceiling without end in x: nothing tells the motion along it.
World endlessCorridor();

struct LidarModel {
  int rows = 64, columns = 1024;
  double vertical_fov_rad = 0.785;
  double sigma_m = 0.01;
  double max_range_m = 40.0;
  /// Duration of a sweep; 0 for all points at the stamp.
  double sweep_s = 0.1;
  Pose3 T_base_lidar = Pose3::fromYawPitchRoll(-0.06, 0.01, 0.3, 0.02, 0.01, 0.03);
};

/// T_world_base at seconds since the start.
using Trajectory = std::function<Pose3(double)>;

/// Walks a loop through the room at about 1 m/s while shaking by ±4° and ±4 cm at 2 Hz.
Trajectory handHeldWalk();
/// Drives along x with smooth turns.
Trajectory wheeledDrive();
Trajectory atRest();
/// Straight along x at constant speed.
Trajectory straight(double speed_m_s);

/// The sweep that starts at `time_s`: columns in the order of time, azimuth −π … π; point times are
/// set when the sweep lasts. The stamp is the start.
Scan sweep(const World& world, const LidarModel& lidar, const Trajectory& T_world_base,
           double time_s, std::mt19937_64& random);

/// Root mean square distance of the positions after the best rigid alignment [m].
double absoluteTrajectoryError(const std::vector<Pose3>& truth, const std::vector<Pose3>& estimate);

}  // namespace dynemo::test
