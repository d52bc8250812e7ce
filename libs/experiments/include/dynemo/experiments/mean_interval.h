// A mean with its uncertainty.
#pragma once

#include <cstddef>
#include <vector>

namespace dynemo::experiments {

struct MeanInterval {
  double mean = 0.0;
  /// Half width of the two-sided 95 % interval of the mean (Student's t); 0 with fewer than two
  /// values.
  double half_width = 0.0;
  std::size_t count = 0;
};

MeanInterval meanInterval(const std::vector<double>& values);

}  // namespace dynemo::experiments
