#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dynemo/core/point_cloud.h"

namespace dynemo {

/// The points of a scan by row (elevation) and column (azimuth).
struct RangeImage {
  int rows = 0, columns = 0;
  bool wraps = false;               ///< the last column is next to the first
  std::vector<std::int32_t> point;  ///< row by row; −1 where there is none

  std::int32_t at(int row, int column) const {
    return point[static_cast<std::size_t>(row * columns + column)];
  }
};

/// From the rows and columns of an organised cloud; else, for a list of points ring by ring, rows
/// from the order of the points and columns from their azimuth. Empty when the list has no such
/// order.
std::optional<RangeImage> rangeImage(const PointCloud& cloud);

}  // namespace dynemo
