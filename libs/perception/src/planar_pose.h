#pragma once

#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/perception/tag_pose.h"

namespace dynemo {

/// Both poses T_camera_tag that IPPE finds for a square seen at four pixels; empty when the lens
/// model or the solver cannot handle them. Works in a camera turned towards the tag, so wide-angle
/// images are no special case.
std::vector<Pose3> planarPoses(const CameraModel& camera, const TagCornerObservation& tag,
                               double size_m);

}  // namespace dynemo
