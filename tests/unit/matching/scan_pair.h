// Two scans of a made-up place with the truth.
#pragma once

#include "dynemo/core/point_cloud.h"
#include "synthetic_world.h"

namespace dynemo::test {

struct ScanPair {
  Scan target, source;
  Pose3 T_target_source;
};

inline LidarModel stillLidar() {
  LidarModel lidar;
  lidar.rows = 32;
  lidar.columns = 512;
  lidar.sweep_s = 0.0;
  return lidar;
}

inline ScanPair scanPair(const World& world, const Pose3& T_world_target,
                         const Pose3& T_world_source) {
  std::mt19937_64 random(7);
  const auto at = [&](const Pose3& T_world_base) {
    return sweep(
        world, stillLidar(), [&](double) { return T_world_base; }, 0.0, random);
  };
  return {at(T_world_target), at(T_world_source), T_world_target.inverse() * T_world_source};
}

inline ScanPair roomPair() {
  return scanPair(furnishedRoom(), Pose3::fromYawPitchRoll(-1.5, -1.0, 0.6, 0.3, 0, 0),
                  Pose3::fromYawPitchRoll(-0.3, -1.9, 0.62, 0.8, 0.01, -0.01));
}

inline ScanPair corridorPair() {
  return scanPair(endlessCorridor(), Pose3::translation(0, 0.2, 0.8),
                  Pose3::translation(0.7, 0.1, 0.8));
}

/// Moves the guess by a fixed error of about these sizes.
inline Pose3 disturbed(const Pose3& T, double translation_m, double rotation_rad) {
  Vector6 d;
  d << translation_m * Vector3(0.8, -0.59, 0.1), rotation_rad * Vector3(0.1, -0.1, 0.99);
  return T.retract(d);
}

}  // namespace dynemo::test
