// What a spinning LiDAR sees.
#pragma once

#include <cstdint>
#include <vector>

#include "dynemo/simulation/scene.h"

namespace dynemo::simulation {

/// One sweep: ring by ring from the top; within a ring from azimuth −180° counter-clockwise.
struct Sweep {
  std::vector<Eigen::Vector3f>
      points;  ///< sensor frame; at the instant of each shot when distorted
  std::vector<std::uint16_t> ring, column;
  std::vector<float> range_m;
};

/// Keeps buffers between sweeps; one per thread.
class Lidar {
 public:
  explicit Lidar(const Scene& scene);

  /// `index` numbers the sweeps and seeds their noise. Undistorted: everything at t_s; distorted:
  /// column c at t_s + turned(c) / rate.
  Sweep sweep(std::uint64_t index, double t_s);

 private:
  void aim(double t_s);

  const Scene& scene_;
  const LidarSpec& spec_;
  Pose3 T_base_lidar_;
  RayCaster::Snapshot snapshot_;
  std::vector<Eigen::Vector3f> directions_;  ///< sensor frame, ring by ring
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
};

}  // namespace dynemo::simulation
