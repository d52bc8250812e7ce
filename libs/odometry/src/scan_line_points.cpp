#include "dynemo/odometry/scan_line_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace dynemo {
namespace {

constexpr float kRadius_m = 1.0F;
constexpr float kSpacing_m = 0.1F;
constexpr std::size_t kMinNeighbors = 8;
/// Of the variances across the surface and across the lines.
constexpr float kMaxFlatness = 0.005F;
/// Of the variances across and along the lines.
constexpr float kMinCover = 0.1F;
/// Of the points from the plane.
constexpr float kMaxDeviation_m = 0.04F;
/// Two lines always lie in a plane, whatever they lie on; between three, no gap is this share of
/// the whole, in whatever direction one looks.
constexpr float kMaxGap = 0.6F;
constexpr int kDirections = 6;
/// Between lines of one sweep.
constexpr float kLineGap_rad = 0.007F;

}  // namespace

std::optional<Eigen::Vector3f> ScanLinePoints::add(const Eigen::Vector3f& point,
                                                   float elevation_rad) {
  const CellCoordinates home = cellOf(point, 1.0F / kRadius_m);
  gather(home, point);
  const bool crowded = std::any_of(neighbors_.begin(), neighbors_.end(), [&](const LinePoint& n) {
    return (n.p - point).squaredNorm() < kSpacing_m * kSpacing_m;
  });
  if (!crowded) {
    const std::uint32_t number = index_.findOrAdd(home);
    if (number == cells_.size()) cells_.push_back({home, {}});
    cells_[number].points.push_back({point, sweep_, elevation_rad});
    neighbors_.push_back({point, sweep_, elevation_rad});
  }
  if (neighbors_.size() < kMinNeighbors || !onThreeLines()) return std::nullopt;
  return normalOfNeighbors();
}

std::optional<Eigen::Vector3f> ScanLinePoints::normalOfNeighbors() {
  fitted_.clear();
  for (const LinePoint& n : neighbors_) fitted_.push_back(n.p);
  const Eigen::Vector3f origin = fitted_.front();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  for (const Eigen::Vector3f& p : fitted_) {
    const Eigen::Vector3f d = p - origin;
    sum += d;
    squares.noalias() += d * d.transpose();
  }
  const auto count = static_cast<float>(fitted_.size());
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(squares - sum * sum.transpose() / count);
  const Eigen::Vector3f& spread = solver.eigenvalues();
  if (!(spread[1] > kMinCover * spread[2] && spread[0] <= kMaxFlatness * spread[1] &&
        spread[0] <= kMaxDeviation_m * kMaxDeviation_m * count))
    return std::nullopt;
  const auto& axes = solver.eigenvectors();
  if (!coverAnArea(axes.col(1), axes.col(2))) return std::nullopt;
  return axes.col(0);
}

bool ScanLinePoints::coverAnArea(const Eigen::Vector3f& u, const Eigen::Vector3f& v) {
  for (int i = 0; i < kDirections; ++i) {
    const float angle = std::numbers::pi_v<float> * static_cast<float>(i) / kDirections;
    const Eigen::Vector3f direction = std::cos(angle) * u + std::sin(angle) * v;
    along_.clear();
    for (const Eigen::Vector3f& p : fitted_) along_.push_back(direction.dot(p));
    std::sort(along_.begin(), along_.end());
    float gap = 0.0F;
    for (std::size_t k = 1; k < along_.size(); ++k) gap = std::max(gap, along_[k] - along_[k - 1]);
    if (gap > kMaxGap * (along_.back() - along_.front())) return false;
  }
  return true;
}

/// A line around a corner lies in a plane, too: its own.
bool ScanLinePoints::onThreeLines() {
  std::sort(neighbors_.begin(), neighbors_.end(), [](const LinePoint& a, const LinePoint& b) {
    return std::pair(a.sweep, a.elevation_rad) < std::pair(b.sweep, b.elevation_rad);
  });
  int lines = 1;
  for (std::size_t i = 1; i < neighbors_.size(); ++i) {
    const LinePoint &a = neighbors_[i - 1], &b = neighbors_[i];
    lines += a.sweep != b.sweep || b.elevation_rad - a.elevation_rad > kLineGap_rad ? 1 : 0;
  }
  return lines >= 3;
}

void ScanLinePoints::gather(const CellCoordinates& home, const Eigen::Vector3f& point) {
  neighbors_.clear();
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        const std::uint32_t number = index_.find(home + CellCoordinates(dx, dy, dz));
        if (number == CellIndex::kNone) continue;
        for (const LinePoint& n : cells_[number].points) {
          if ((n.p - point).squaredNorm() <= kRadius_m * kRadius_m) neighbors_.push_back(n);
        }
      }
    }
  }
}

void ScanLinePoints::removeFartherThan(const Eigen::Vector3f& center, double radius_m) {
  const auto radius2 = static_cast<float>(radius_m * radius_m);
  std::erase_if(cells_, [&](const Cell& cell) {
    const Eigen::Vector3f middle =
        (cell.coordinates.cast<float>() + Eigen::Vector3f::Constant(0.5F)) * kRadius_m;
    return (middle - center).squaredNorm() > radius2;
  });
  index_.clear();
  for (const Cell& cell : cells_) index_.findOrAdd(cell.coordinates);
}

void ScanLinePoints::clear() {
  index_.clear();
  cells_.clear();
  sweep_ = 0;
}

}  // namespace dynemo
