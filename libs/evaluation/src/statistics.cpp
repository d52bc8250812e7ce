#include "dynemo/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dynemo {

double median(std::span<const double> values) {
  if (values.empty()) return Statistics::kNone;
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

Statistics summarize(std::span<const double> values) {
  Statistics s;
  s.count = values.size();
  if (values.empty()) return s;
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0, deviations = 0.0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  s.mean = sum / n;
  for (const double v : values) deviations += (v - s.mean) * (v - s.mean);
  s.rmse = std::sqrt(squares / n);
  s.std = std::sqrt(deviations / n);
  s.median = median(values);
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  s.min = *min;
  s.max = *max;
  return s;
}

}  // namespace dynemo
