// Scan to keyframe, as the published baseline does it.
#pragma once

#include <memory>

#include "dynemo/odometry/odometry_params.h"
#include "dynemo/odometry/scan_odometry.h"

namespace dynemo {

/// Registers every scan by GICP to the last keyframe's scan, without deskew, kernel or normal gate;
/// a scan farther than the thresholds from the keyframe becomes the next one
/// (scan_matching_odometry of hdl_graph_slam, Koide et al. 2019, on which S-Graphs builds).
std::unique_ptr<ScanOdometry> makeKeyframeGicpOdometry(const OdometryParams& params);

}  // namespace dynemo
