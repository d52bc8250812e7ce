#pragma once

#include <cstddef>
#include <limits>
#include <span>

namespace dynemo {

/// Summary of a list of non-negative errors, in their unit. Not-a-number throughout when the list
/// is empty.
struct Statistics {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double rmse = kNone;  ///< √(mean of squares)
  double mean = kNone;
  double median = kNone;  ///< mean of the two middle values when the count is even
  double std = kNone;     ///< of the population: √(mean of squared deviations)
  double min = kNone;
  double max = kNone;
  std::size_t count = 0;
};

Statistics summarize(std::span<const double> values);

/// The middle value, as in Statistics; not-a-number for an empty list.
double median(std::span<const double> values);

}  // namespace dynemo
