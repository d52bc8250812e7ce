// Scan to local map: the project's own odometry.
#pragma once

#include <memory>

#include "dynemo/odometry/odometry_params.h"
#include "dynemo/odometry/scan_odometry.h"

namespace dynemo {

/// Predicts the pose at the middle of the sweep, reduces the scan to surface points, registers them
/// to the voxel map together with the twist during the sweep, and adds them to the map. The first
/// sweep's motion is unknown until the second has been registered; the map is then rebuilt from it,
/// its origin staying at the first stamp.
std::unique_ptr<ScanOdometry> makeLocalMapOdometry(const OdometryParams& params);

}  // namespace dynemo
