#pragma once

#include "generated_graph.h"

namespace dynemo::test {

/// Where the robot of a GeneratedWorld really is at the keyframe of that frame_index.
Pose3 trueRobotPose(const WorldParams& params, int k);

}  // namespace dynemo::test
