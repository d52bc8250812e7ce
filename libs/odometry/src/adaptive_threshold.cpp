#include "dynemo/odometry/adaptive_threshold.h"

#include <cmath>

namespace dynemo {

AdaptiveThreshold::AdaptiveThreshold(double initial_sigma_m, double memory)
    : mean_square_m2_(initial_sigma_m * initial_sigma_m), memory_(memory) {}

void AdaptiveThreshold::add(double translation_m, double rotation_rad, double mean_range_m) {
  const double displacement_m = translation_m + 2.0 * mean_range_m * std::sin(0.5 * rotation_rad);
  mean_square_m2_ = memory_ * mean_square_m2_ + (1.0 - memory_) * displacement_m * displacement_m;
}

double AdaptiveThreshold::sigma_m() const { return std::sqrt(mean_square_m2_); }

}  // namespace dynemo
