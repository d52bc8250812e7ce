// A pinhole camera that looks at the scene, for rendering and for writing into the picture.
#pragma once

#include <optional>

#include "dynemo/core/se3.h"

namespace dynemo {

struct PictureCamera {
  /// Optical frame: x right, y down, z forward.
  Pose3 T_map_camera;
  double focal_px = 1.0;
  int width_px = 0, height_px = 0;

  /// Pixel of a point; empty behind the camera.
  std::optional<Vector2> project(const Vector3& p_map) const;
  /// Distance to the point it looks at [m].
  double distance_m = 1.0;
};

/// Looks at a point from a direction (azimuth about the map's z axis, elevation over its plane) and
/// a distance, with a vertical field of view [rad].
PictureCamera lookAt(const Vector3& p_map, double distance_m, double azimuth_rad,
                     double elevation_rad, double field_of_view_rad, int width_px, int height_px);

}  // namespace dynemo
