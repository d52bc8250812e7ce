#pragma once

#include <optional>

#include "dynemo/core/point_cloud.h"

namespace dynemo {

/// Height of the ground under the robot: the z of the near-horizontal plane below the base, in a frame at the base's
/// origin that is levelled by R_level_base [m]; empty when the scan shows none. Deterministic RANSAC over the points
/// within a few metres, refined by least squares.
std::optional<double> groundHeight(const Scan& scan, const Matrix3& R_level_base);

}  // namespace dynemo
