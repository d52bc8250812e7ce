#include "picture_camera.h"

#include <cmath>

namespace dynemo {

std::optional<Vector2> PictureCamera::project(const Vector3& p_map) const {
  const Vector3 p = T_map_camera.inverse() * p_map;
  if (p.z() <= 1e-6) return std::nullopt;
  return Vector2(0.5 * width_px + focal_px * p.x() / p.z(),
                 0.5 * height_px + focal_px * p.y() / p.z());
}

PictureCamera lookAt(const Vector3& p_map, double distance_m, double azimuth_rad,
                     double elevation_rad, double field_of_view_rad, int width_px, int height_px) {
  PictureCamera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.focal_px = 0.5 * height_px / std::tan(0.5 * field_of_view_rad);
  camera.distance_m = distance_m;
  const Vector3 back(std::cos(elevation_rad) * std::cos(azimuth_rad),
                     std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad));
  const Vector3 right(-std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0);
  camera.T_map_camera.R.col(0) = right;
  camera.T_map_camera.R.col(1) = (-back).cross(right);
  camera.T_map_camera.R.col(2) = -back;
  camera.T_map_camera.t = p_map + distance_m * back;
  return camera;
}

}  // namespace dynemo
