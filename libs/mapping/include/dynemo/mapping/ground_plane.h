#pragma once

#include <optional>

#include "dynemo/core/point_cloud.h"

namespace dynemo {

/// The ground under the robot, in a frame at the base's origin with the axes of R_level_base.
struct GroundPlane {
  Vector3 normal = Vector3::UnitZ();  ///< unit, upwards
  double height_m = 0.0;              ///< z of the plane at the base's origin
};

/// The near-horizontal plane below the base, with `R_level_base` the base's orientation in a frame
/// that is level as far as known; empty when the scan shows none. Deterministic RANSAC over the
/// points within a few metres, refined by least squares.
std::optional<GroundPlane> findGround(const Scan& scan, const Matrix3& R_level_base);

/// The smallest rotation that turns the ground's normal upright.
Matrix3 levelling(const GroundPlane& ground);

}  // namespace dynemo
