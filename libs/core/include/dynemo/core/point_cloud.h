// A LiDAR scan as the stages exchange it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

/// Indices into the points of one scan, ascending.
using PointIndices = std::vector<std::uint32_t>;

/// Points of one sweep in the sensor frame [m]; every point is finite.
struct PointCloud {
  std::vector<Eigen::Vector3f> points;
  /// Per point, seconds after the scan's stamp; empty when the sensor gives none.
  std::vector<float> time_offset_s;
  /// Per point, the row (ring or image row) and column of an organised sensor; empty when
  /// unorganised.
  std::vector<std::uint16_t> row, column;
  std::uint16_t rows = 0, columns = 0;

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  bool organised() const { return !row.empty(); }

  /// The points that are not in `removed` (ascending indices), with their per-point attributes.
  PointCloud without(std::span<const std::uint32_t> removed) const;
};

/// A sweep with its time and mounting.
struct Scan {
  Stamp stamp;
  PointCloud cloud;
  Pose3 T_base_lidar;
};

}  // namespace dynemo
