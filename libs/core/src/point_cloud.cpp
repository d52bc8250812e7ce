#include "dynemo/core/point_cloud.h"

namespace dynemo {

PointCloud PointCloud::without(std::span<const std::uint32_t> removed) const {
  PointCloud kept;
  kept.rows = rows;
  kept.columns = columns;
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    while (next < removed.size() && removed[next] < i) ++next;
    if (next < removed.size() && removed[next] == i) continue;
    kept.points.push_back(points[i]);
    if (!time_offset_s.empty()) kept.time_offset_s.push_back(time_offset_s[i]);
    if (organised()) {
      kept.row.push_back(row[i]);
      kept.column.push_back(column[i]);
    }
  }
  return kept;
}

}  // namespace dynemo
