// Removal of the distortion that motion during a sweep causes.
#pragma once

#include "dynemo/core/point_cloud.h"
#include "dynemo/odometry/sweep_motion.h"

namespace dynemo {

/// The cloud as it would have been measured at `at_s` after the stamp, for a base that moves by
/// `motion` around the middle of the sweep. The result has no point times; a cloud without them
/// comes back unchanged.
PointCloud deskew(const PointCloud& cloud, const Pose3& T_base_lidar, const SweepMotion& motion,
                  double at_s);

}  // namespace dynemo
