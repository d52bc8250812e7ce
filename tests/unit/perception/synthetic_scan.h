// A ray-cast scan of a ground plane, upright walls and boxes.
#pragma once

#include <vector>

#include "dynemo/core/point_cloud.h"

namespace dynemo::test {

struct SceneBox {
  Pose3 T_world_box;
  Vector3 half_side_m;
};

struct Scene {
  double ground_z = 0.0;
  std::vector<SceneBox> boxes;  ///< walls are thin long boxes
};

struct SimulatedScan {
  Scan scan;
  std::vector<int> box_of_point;  ///< index into the scene's boxes, or −1 for the ground
};

/// Rings × columns rays from T_world_lidar, ±22.5° of elevation.
SimulatedScan castScan(const Scene& scene, const Pose3& T_world_base, const Pose3& T_base_lidar,
                       int rings, int columns, double sigma_m);

}  // namespace dynemo::test
