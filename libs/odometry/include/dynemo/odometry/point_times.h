// When a sweep was measured.
#pragma once

#include "dynemo/core/point_cloud.h"

namespace dynemo {

/// The instant halfway between the first and the last point, seconds after the stamp; 0 for a cloud
/// without point times, which counts as a scan of one instant.
double middleOfSweep(const PointCloud& cloud);

}  // namespace dynemo
