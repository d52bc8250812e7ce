#include "dynemo/experiments/mean_interval.h"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace dynemo::experiments {

MeanInterval meanInterval(const std::vector<double>& values) {
  MeanInterval result;
  result.count = values.size();
  if (values.empty()) return result;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) result.mean += v / n;
  if (values.size() < 2) return result;
  double squares = 0.0;
  for (const double v : values) squares += (v - result.mean) * (v - result.mean);
  constexpr double kUpperTail = 0.975;
  const double t = boost::math::quantile(boost::math::students_t(n - 1), kUpperTail);
  result.half_width = t * std::sqrt(squares / (n - 1) / n);
  return result;
}

}  // namespace dynemo::experiments
