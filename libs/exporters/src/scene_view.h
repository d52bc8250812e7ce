// What there is to see, for every format that has a camera.
#pragma once

#include "dynemo/exporters/run_result.h"

namespace dynemo {

/// The ball that holds most of what there is to see [m, map frame].
struct SceneView {
  Vector3 center = Vector3::Zero();
  double radius_m = 1.0;
  /// The rectangle around it seen from above: direction of its long side about z, half of both
  /// sides.
  double yaw_rad = 0.0;
  Vector2 half_m = Vector2::Ones();
};
SceneView viewOf(const CSceneGraph& graph);

/// The way as the odometry has it without any correction, anchored at the first keyframe.
std::vector<Vector3> uncorrectedWay(const RunResult& run);

}  // namespace dynemo
