#include "dynemo/odometry/adaptive_threshold.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dynemo {
namespace {

TEST(AdaptiveThreshold, StartsAtTheInitialValueAndFollowsTheErrors) {
  AdaptiveThreshold threshold(0.3, 0.9);
  EXPECT_DOUBLE_EQ(threshold.sigma_m(), 0.3);
  for (int i = 0; i < 200; ++i) threshold.add(0.05, 0.0, 4.0);
  EXPECT_NEAR(threshold.sigma_m(), 0.05, 1e-6);
}

TEST(AdaptiveThreshold, RotationCountsByTheDisplacementAtTheMeanRange) {
  AdaptiveThreshold threshold(0.0, 0.5);
  threshold.add(0.0, 0.1, 4.0);
  EXPECT_NEAR(threshold.sigma_m(), std::sqrt(0.5) * 8.0 * std::sin(0.05), 1e-12);
}

}  // namespace
}  // namespace dynemo
