#include "synthetic_scan.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

namespace dynemo::test {
namespace {

constexpr double kElevation_rad = 22.5 * std::numbers::pi / 180.0;
constexpr double kMaxRange_m = 30.0;

/// Distance along the ray to the box (slab method).
std::optional<double> hit(const SceneBox& box, const Vector3& origin, const Vector3& direction) {
  const Pose3 T_box_world = box.T_world_box.inverse();
  const Vector3 o = T_box_world * origin, d = T_box_world.R * direction;
  double near = 0.0, far = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double a = (-box.half_side_m[k] - o[k]) / d[k], b = (box.half_side_m[k] - o[k]) / d[k];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  if (near > far || near <= 0.0) return std::nullopt;
  return near;
}

struct Hit {
  double range_m = kMaxRange_m;
  int box = -2;  ///< −1 ground, −2 nothing
};

Hit cast(const Scene& scene, const Vector3& origin, const Vector3& direction) {
  Hit nearest;
  const double to_ground = (scene.ground_z - origin.z()) / direction.z();
  if (to_ground > 0.0 && to_ground < nearest.range_m) nearest = {to_ground, -1};
  for (std::size_t i = 0; i < scene.boxes.size(); ++i) {
    const auto range = hit(scene.boxes[i], origin, direction);
    if (range && *range < nearest.range_m) nearest = {*range, static_cast<int>(i)};
  }
  return nearest;
}

}  // namespace

SimulatedScan castScan(const Scene& scene, const Pose3& T_world_base, const Pose3& T_base_lidar,
                       int rings, int columns, double sigma_m) {
  const Pose3 T_world_lidar = T_world_base * T_base_lidar;
  std::mt19937 generator(1);
  std::normal_distribution<double> noise(0.0, sigma_m);
  SimulatedScan result;
  result.scan.T_base_lidar = T_base_lidar;
  for (int r = 0; r < rings; ++r) {
    const double elevation = kElevation_rad * (1.0 - 2.0 * r / (rings - 1));
    for (int c = 0; c < columns; ++c) {
      const double azimuth = 2.0 * std::numbers::pi * c / columns;
      const Vector3 ray(std::cos(elevation) * std::cos(azimuth),
                        std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Hit found = cast(scene, T_world_lidar.t, T_world_lidar.R * ray);
      if (found.box == -2) continue;
      result.scan.cloud.points.push_back(((found.range_m + noise(generator)) * ray).cast<float>());
      result.box_of_point.push_back(found.box);
    }
  }
  return result;
}

}  // namespace dynemo::test
