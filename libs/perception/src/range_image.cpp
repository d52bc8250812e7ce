#include "dynemo/perception/range_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dynemo {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
/// Azimuth turns back by at least this where a ring ends.
constexpr float kRingEnd_rad = 0.5F;
constexpr std::size_t kMinRings = 4, kMaxRings = 512, kMinPointsPerRing = 24;
constexpr double kMinColumns = 90.0, kMaxColumns = 8192.0;
/// Scatter of the elevation within a ring, as a fraction of the distance between rings.
constexpr float kMaxRingScatter = 0.3F;

struct Ring {
  std::size_t begin = 0, end = 0;
  float elevation_rad = 0.0F;  ///< median
};

template <class T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool fullTurn(const PointCloud& cloud, const RangeImage& image) {
  // Neighbouring columns across the seam are as close as any others.
  const auto direction = [&](int row, int column) -> std::optional<Eigen::Vector3f> {
    const std::int32_t i = image.at(row, column);
    if (i < 0) return std::nullopt;
    return cloud.points[static_cast<std::size_t>(i)].normalized();
  };
  std::vector<float> across, within;
  for (int row = 0; row < image.rows; ++row) {
    const auto first = direction(row, 0), last = direction(row, image.columns - 1);
    if (first && last) across.push_back((*first - *last).norm());
    const auto a = direction(row, image.columns / 2), b = direction(row, image.columns / 2 + 1);
    if (a && b) within.push_back((*a - *b).norm());
  }
  return !across.empty() && !within.empty() && median(across) < 3.0F * median(within);
}

RangeImage fromGrid(const PointCloud& cloud) {
  RangeImage image;
  image.rows = cloud.rows;
  image.columns = cloud.columns;
  image.point.assign(static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns),
                     -1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    image.point[static_cast<std::size_t>(cloud.row[i]) * cloud.columns + cloud.column[i]] =
        static_cast<std::int32_t>(i);
  }
  image.wraps = fullTurn(cloud, image);
  return image;
}

/// +1 or −1: how the azimuth runs along the list; 0 when it does not run one way.
float direction(const std::vector<float>& azimuth) {
  std::size_t up = 0, down = 0;
  for (std::size_t i = 1; i < azimuth.size(); ++i) {
    const float step = azimuth[i] - azimuth[i - 1];
    if (std::abs(step) > kRingEnd_rad) continue;
    (step > 0.0F ? up : down)++;
  }
  if (up > 20 * down) return 1.0F;
  if (down > 20 * up) return -1.0F;
  return 0.0F;
}

std::vector<Ring> splitIntoRings(const std::vector<float>& azimuth,
                                 const std::vector<float>& elevation, float sense) {
  std::vector<Ring> rings(1);
  for (std::size_t i = 1; i < azimuth.size(); ++i) {
    if (sense * (azimuth[i] - azimuth[i - 1]) > -kRingEnd_rad) continue;
    rings.back().end = i;
    rings.push_back({i, 0, 0.0F});
  }
  rings.back().end = azimuth.size();
  for (Ring& ring : rings) {
    ring.elevation_rad =
        median(std::vector<float>(elevation.begin() + static_cast<std::ptrdiff_t>(ring.begin),
                                  elevation.begin() + static_cast<std::ptrdiff_t>(ring.end)));
  }
  return rings;
}

/// Distance between rings that are next to each other in elevation; parts of one ring do not count.
float ringSpacing(const std::vector<Ring>& rings) {
  std::vector<float> elevations, gaps;
  for (const Ring& ring : rings) elevations.push_back(ring.elevation_rad);
  std::sort(elevations.begin(), elevations.end());
  const float least =
      0.2F * (elevations.back() - elevations.front()) / static_cast<float>(elevations.size());
  for (std::size_t i = 1; i < elevations.size(); ++i) {
    const float gap = elevations[i] - elevations[i - 1];
    if (gap > least) gaps.push_back(gap);
  }
  return gaps.empty() ? 0.0F : median(gaps);
}

/// A sweep that does not start at ±π has each of its rings cut in two there.
std::vector<std::size_t> rowOfRing(const std::vector<Ring>& rings, float spacing,
                                   std::size_t& rows) {
  std::vector<std::size_t> order(rings.size()), row(rings.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rings[a].elevation_rad > rings[b].elevation_rad;
  });
  rows = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same =
        k > 0 && (order[k] == order[k - 1] + 1 || order[k] + 1 == order[k - 1]) &&
        rings[order[k - 1]].elevation_rad - rings[order[k]].elevation_rad < 0.3F * spacing;
    if (k > 0 && !same) ++rows;
    row[order[k]] = rows;
  }
  ++rows;
  return row;
}

std::optional<double> columnStep(const std::vector<float>& azimuth, float sense) {
  std::vector<float> steps;
  for (std::size_t i = 1; i < azimuth.size(); ++i) {
    const float step = sense * (azimuth[i] - azimuth[i - 1]);
    if (step > 0.0F && step < kRingEnd_rad) steps.push_back(step);
  }
  if (steps.empty()) return std::nullopt;
  const double columns = std::round(kTurn / static_cast<double>(median(steps)));
  if (columns < kMinColumns || columns > kMaxColumns) return std::nullopt;
  return kTurn / columns;
}

/// Where the columns lie within a step: the circular mean, so that rounding puts each azimuth in
/// the middle of its column.
double columnPhase(const std::vector<float>& azimuth, double step_rad) {
  double c = 0.0, s = 0.0;
  for (const float a : azimuth) {
    const double angle = kTurn * static_cast<double>(a) / step_rad;
    c += std::cos(angle);
    s += std::sin(angle);
  }
  return std::atan2(s, c) / kTurn;
}

bool scattered(const std::vector<Ring>& rings, const std::vector<float>& elevation, float spacing) {
  std::vector<float> off;
  for (const Ring& ring : rings) {
    for (std::size_t i = ring.begin; i < ring.end; ++i)
      off.push_back(std::abs(elevation[i] - ring.elevation_rad));
  }
  return !(median(off) < kMaxRingScatter * spacing);
}

std::optional<RangeImage> fromRings(const PointCloud& cloud) {
  const std::size_t n = cloud.size();
  if (n < kMinRings * kMinPointsPerRing) return std::nullopt;
  std::vector<float> azimuth(n), elevation(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    azimuth[i] = std::atan2(p.y(), p.x());
    elevation[i] = std::atan2(p.z(), p.head<2>().norm());
  }
  const float sense = direction(azimuth);
  if (sense == 0.0F) return std::nullopt;
  const std::vector<Ring> rings = splitIntoRings(azimuth, elevation, sense);
  if (rings.size() < kMinRings || rings.size() > kMaxRings || n < rings.size() * kMinPointsPerRing)
    return std::nullopt;
  const float spacing = ringSpacing(rings);
  if (scattered(rings, elevation, spacing)) return std::nullopt;
  const auto step = columnStep(azimuth, sense);
  if (!step) return std::nullopt;

  std::size_t rows = 0;
  const std::vector<std::size_t> row = rowOfRing(rings, spacing, rows);
  RangeImage image;
  image.rows = static_cast<int>(rows);
  image.columns = static_cast<int>(std::lround(kTurn / *step));
  image.wraps = true;
  image.point.assign(rows * static_cast<std::size_t>(image.columns), -1);
  const double phase = columnPhase(azimuth, *step);
  for (std::size_t r = 0; r < rings.size(); ++r) {
    for (std::size_t i = rings[r].begin; i < rings[r].end; ++i) {
      auto column = static_cast<int>(std::lround(static_cast<double>(azimuth[i]) / *step - phase));
      column = (column % image.columns + image.columns) % image.columns;
      auto& cell = image.point[row[r] * static_cast<std::size_t>(image.columns) +
                               static_cast<std::size_t>(column)];
      if (cell < 0) cell = static_cast<std::int32_t>(i);
    }
  }
  return image;
}

}  // namespace

std::optional<RangeImage> rangeImage(const PointCloud& cloud) {
  return cloud.organised() ? fromGrid(cloud) : fromRings(cloud);
}

}  // namespace dynemo
