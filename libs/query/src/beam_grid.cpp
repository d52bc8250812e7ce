#include "beam_grid.h"

#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

// Directions are laid out without trigonometry: rows by the sine of the elevation, columns by the
// place on a square around the vertical axis, which grows with the azimuth. A cell is 0.6° to 1.3°.
constexpr int kRows = 180, kColumns = 360;
/// Directions further apart than this are not searched: near the sensor the rays are dense.
constexpr float kMostSine = 0.1f, kMostSineOfAzimuth = 0.2f;

int rowOf(float sine_of_elevation) {
  const int row = static_cast<int>(0.5f * (sine_of_elevation + 1.0f) * kRows);
  return std::clamp(row, 0, kRows - 1);
}

/// In [0, 4), growing with the azimuth from the direction of -x.
float aroundSquare(float x, float y) {
  const float length = std::abs(x) + std::abs(y);
  if (!(length > 0.0f)) return 2.0f;
  return y < 0.0f ? 1.0f + x / length : 3.0f - x / length;
}

int columnOf(float x, float y) {
  return std::min(static_cast<int>(aroundSquare(x, y) * (0.25f * kColumns)), kColumns - 1);
}

}  // namespace

BeamGrid::BeamGrid(const PointCloud& cloud, const std::vector<BeamEnd>& ends) {
  std::vector<std::uint32_t> cell(cloud.size());
  std::vector<float> range_m(cloud.size());
  first_.assign(kRows * kColumns + 1, 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    range_m[i] = p.norm();
    const int row = range_m[i] > 0.0f ? rowOf(p.z() / range_m[i]) : 0;
    cell[i] = static_cast<std::uint32_t>(row * kColumns + columnOf(p.x(), p.y()));
    ++first_[cell[i] + 1];
  }
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  beams_.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f direction = range_m[i] > 0.0f
                                          ? Eigen::Vector3f(cloud.points[i] / range_m[i])
                                          : Eigen::Vector3f::UnitX();
    beams_[next[cell[i]]++] = {direction, range_m[i], ends[i]};
  }
}

Sight BeamGrid::look(const Eigen::Vector3f& p_lidar, const SightParams& params) const {
  const auto hit_m = static_cast<float>(params.hit_m);
  const auto radius_m = static_cast<float>(params.ray_radius_m);
  const auto behind_m = static_cast<float>(params.behind_m);
  const float widest_m = std::max(hit_m, radius_m);
  const float range2 = p_lidar.squaredNorm();
  const float range_m = std::sqrt(range2);
  if (range_m < 2.0f * widest_m) return Sight::kNothing;

  // The rows and columns that a cone around the place touches.
  const float up = p_lidar.z() / range_m;
  const float level = std::sqrt(std::max(0.0f, 1.0f - up * up));
  const float sine = std::min(widest_m / range_m, kMostSine);
  const float cosine = std::sqrt(1.0f - sine * sine);
  const bool at_pole = level < sine;
  const int lowest = at_pole && up < 0.0f ? 0 : rowOf(up * cosine - level * sine);
  const int highest = at_pole && up > 0.0f ? kRows - 1 : rowOf(up * cosine + level * sine);
  const float turn = std::min(sine / std::max(level, sine), kMostSineOfAzimuth);
  const float keep = std::sqrt(1.0f - turn * turn);
  const float x = p_lidar.x(), y = p_lidar.y();
  const int begin = columnOf(x * keep + y * turn, y * keep - x * turn);
  const int end = columnOf(x * keep - y * turn, y * keep + x * turn);

  const float hit2 = hit_m * hit_m, near2 = radius_m * radius_m, widest2 = widest_m * widest_m;
  bool hit = false, through = false, hidden = false;
  const auto pass = [&](std::size_t from, std::size_t to) {
    for (std::uint32_t i = first_[from]; i < first_[to]; ++i) {
      const Beam& beam = beams_[i];
      const float along = beam.direction.dot(p_lidar);
      const float aside2 = range2 - along * along;
      if (aside2 > widest2) continue;
      const float beyond = beam.range_m - along;
      const bool at_place = std::abs(beyond) <= behind_m;
      hit |= aside2 <= hit2 && at_place && beam.end == BeamEnd::kThing;
      if (aside2 > near2 || (at_place && beam.end == BeamEnd::kFloor)) continue;
      (beyond > behind_m ? through : hidden) = true;
    }
  };
  for (int row = lowest; row <= highest; ++row) {
    const auto cells = static_cast<std::size_t>(row * kColumns);
    if (begin <= end) {
      pass(cells + static_cast<std::size_t>(begin), cells + static_cast<std::size_t>(end) + 1);
    } else {  // across the direction of -x
      pass(cells, cells + static_cast<std::size_t>(end) + 1);
      pass(cells + static_cast<std::size_t>(begin), cells + kColumns);
    }
    if (hit) return Sight::kHit;
  }
  return through && !hidden ? Sight::kThrough : Sight::kNothing;
}

}  // namespace dynemo
