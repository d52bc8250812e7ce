#include "dynemo/matching/seen_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dynemo {
namespace {

constexpr int kColumns = 180, kRows = 90;
constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kNone = std::numeric_limits<float>::infinity();
/// A point this much nearer than the returns is in front of them: the larger of a length, for
/// rough surfaces and errors of the pose, and a share of the range, for errors of its rotation.
constexpr float kMargin_m = 0.3F, kMarginShare = 0.1F;

struct Cell {
  int row, column;
};

Cell cellOfRay(const Eigen::Vector3f& ray) {
  const float azimuth = std::atan2(ray.y(), ray.x());
  const float elevation = std::atan2(ray.z(), std::hypot(ray.x(), ray.y()));
  const auto bin = [](float share, int count) {
    return std::clamp(static_cast<int>(share * static_cast<float>(count)), 0, count - 1);
  };
  return {bin(elevation / kPi + 0.5F, kRows), bin(azimuth / (2.0F * kPi) + 0.5F, kColumns)};
}

std::size_t indexOf(int row, int column) {
  return static_cast<std::size_t>(row * kColumns + (column + kColumns) % kColumns);
}

}  // namespace

SeenSpace::SeenSpace(std::span<const Eigen::Vector3f> points, const Eigen::Vector3f& sensor)
    : sensor_(sensor), nearest_m_(static_cast<std::size_t>(kRows * kColumns), kNone) {
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3f ray = p - sensor_;
    const Cell cell = cellOfRay(ray);
    float& nearest_m = nearest_m_[indexOf(cell.row, cell.column)];
    nearest_m = std::min(nearest_m, ray.norm());
  }
}

std::optional<float> SeenSpace::freeRange_m(const Eigen::Vector3f& ray) const {
  const Cell cell = cellOfRay(ray);
  if (nearest_m_[indexOf(cell.row, cell.column)] == kNone) return std::nullopt;
  float nearest_m = kNone;
  for (int row = std::max(0, cell.row - 1); row <= std::min(kRows - 1, cell.row + 1); ++row) {
    for (int column = cell.column - 1; column <= cell.column + 1; ++column)
      nearest_m = std::min(nearest_m, nearest_m_[indexOf(row, column)]);
  }
  return nearest_m;
}

double SeenSpace::contradicted(std::span<const Eigen::Vector3f> points_other,
                               const Pose3& T_base_other) const {
  const Eigen::Matrix3f R = T_base_other.R.cast<float>();
  const Eigen::Vector3f t = T_base_other.t.cast<float>() - sensor_;
  std::size_t in_view = 0, in_front = 0;
  for (const Eigen::Vector3f& p : points_other) {
    const Eigen::Vector3f ray = R * p + t;
    const auto free_m = freeRange_m(ray);
    if (!free_m) continue;
    ++in_view;
    if (ray.norm() < *free_m - std::max(kMargin_m, kMarginShare * *free_m)) ++in_front;
  }
  return in_view == 0 ? 0.0 : static_cast<double>(in_front) / static_cast<double>(in_view);
}

}  // namespace dynemo
