#include "dynemo/odometry/point_times.h"

#include <algorithm>

namespace dynemo {

double middleOfSweep(const PointCloud& cloud) {
  if (cloud.time_offset_s.empty()) return 0.0;
  const auto [first, last] =
      std::minmax_element(cloud.time_offset_s.begin(), cloud.time_offset_s.end());
  return 0.5 * (static_cast<double>(*first) + static_cast<double>(*last));
}

}  // namespace dynemo
