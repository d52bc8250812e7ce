// Projection through the lens models of CameraModel, with derivatives, and its inverse.
#pragma once

#include <optional>

#include "dynemo/core/se3.h"
#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

struct Projection {
  Vector2 pixel;
  Eigen::Matrix<double, 2, 3> J_pixel_point;  ///< derivative by the point in the camera frame
};

/// Pixel of a point in the optical frame. Empty where the lens model does not see it: behind a
/// pinhole camera, or outside the region in which the distortion is one-to-one.
std::optional<Projection> project(const CameraModel& camera, const Vector3& p_camera);

/// Unit vector in the optical frame towards a pixel; empty where the distortion cannot be inverted.
std::optional<Vector3> bearing(const CameraModel& camera, const Vector2& pixel);

}  // namespace dynemo
