#include "beam_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dynemo {
namespace {

constexpr int kRows = 180, kColumns = 360;  // one degree
constexpr double kCellsPerRad = kRows / std::numbers::pi;
/// Directions further apart than this are not searched: near the sensor the rays are dense.
constexpr int kMostRows = 6, kMostColumns = 12;

int rowOf(double elevation_rad) {
  const int row = static_cast<int>((elevation_rad + 0.5 * std::numbers::pi) * kCellsPerRad);
  return std::clamp(row, 0, kRows - 1);
}

int columnOf(double azimuth_rad) {
  const int column = static_cast<int>((azimuth_rad + std::numbers::pi) * kCellsPerRad);
  return std::clamp(column, 0, kColumns - 1);
}

}  // namespace

BeamGrid::BeamGrid(const PointCloud& cloud, const std::vector<BeamEnd>& ends) {
  std::vector<std::uint32_t> cell(cloud.size());
  first_.assign(kRows * kColumns + 1, 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    const int row = rowOf(std::atan2(p.z(), std::hypot(p.x(), p.y())));
    cell[i] = static_cast<std::uint32_t>(row * kColumns + columnOf(std::atan2(p.y(), p.x())));
    ++first_[cell[i] + 1];
  }
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  beams_.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float range_m = cloud.points[i].norm();
    const Eigen::Vector3f direction =
        range_m > 0.0f ? Eigen::Vector3f(cloud.points[i] / range_m) : Eigen::Vector3f::UnitX();
    beams_[next[cell[i]]++] = {direction, range_m, ends[i]};
  }
}

Sight BeamGrid::look(const Vector3& p_lidar, const SightParams& params) const {
  const double range_m = p_lidar.norm();
  const double widest_m = std::max(params.hit_m, params.ray_radius_m);
  if (range_m < 2.0 * widest_m) return Sight::kNothing;
  const double elevation = std::atan2(p_lidar.z(), std::hypot(p_lidar.x(), p_lidar.y()));
  const double azimuth = std::atan2(p_lidar.y(), p_lidar.x());
  const double angle = std::asin(widest_m / range_m);
  const int row = rowOf(elevation), column = columnOf(azimuth);
  const int rows = std::min(kMostRows, static_cast<int>(std::ceil(angle * kCellsPerRad)));
  const double narrowing = std::max(0.1, std::cos(elevation));
  const int columns =
      std::min(kMostColumns, static_cast<int>(std::ceil(angle * kCellsPerRad / narrowing)));
  const Eigen::Vector3f p = p_lidar.cast<float>();
  const auto hit2 = static_cast<float>(params.hit_m * params.hit_m);
  const auto near2 = static_cast<float>(params.ray_radius_m * params.ray_radius_m);
  const auto behind = static_cast<float>(params.behind_m);
  bool through = false, hidden = false;
  for (int r = std::max(0, row - rows); r <= std::min(kRows - 1, row + rows); ++r) {
    for (int dc = -columns; dc <= columns; ++dc) {
      const int c = (column + dc + kColumns) % kColumns;
      const std::size_t cell = static_cast<std::size_t>(r * kColumns + c);
      for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
        const Beam& beam = beams_[i];
        const float along = beam.direction.dot(p);
        const float aside2 = p.squaredNorm() - along * along;
        const float beyond = beam.range_m - along;
        const bool at_place = std::abs(beyond) <= behind;
        if (aside2 <= hit2 && at_place && beam.end == BeamEnd::kThing) return Sight::kHit;
        if (aside2 > near2 || (at_place && beam.end == BeamEnd::kFloor)) continue;
        (beyond > behind ? through : hidden) = true;
      }
    }
  }
  return through && !hidden ? Sight::kThrough : Sight::kNothing;
}

}  // namespace dynemo
