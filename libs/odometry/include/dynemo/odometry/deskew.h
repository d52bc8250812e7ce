// Removal of the distortion that motion during a sweep causes.
#pragma once

#include <vector>

#include "dynemo/core/point_cloud.h"
#include "dynemo/odometry/sweep_motion.h"

namespace dynemo {

/// The cloud as it would have been measured at `reference_s` after the stamp, for a base that moves
/// at constant twist. `times_s` has one entry per point, or is empty (nothing changes). The result
/// has no point times.
PointCloud deskew(const PointCloud& cloud, const std::vector<float>& times_s,
                  const Pose3& T_base_lidar, const SweepMotion& motion, double at_s);

}  // namespace dynemo
