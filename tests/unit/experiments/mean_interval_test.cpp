#include "dynemo/experiments/mean_interval.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dynemo::experiments {
namespace {

TEST(MeanInterval, IsStudentsByHand) {
  // Mean 3, sample deviation √2.5 over 5 values; t(0.975, 4) = 2.7764.
  const MeanInterval m = meanInterval({1, 2, 3, 4, 5});
  EXPECT_NEAR(m.mean, 3.0, 1e-12);
  EXPECT_NEAR(m.half_width, 2.7764 * std::sqrt(2.5 / 5), 1e-4);
  EXPECT_EQ(m.count, 5u);
}

TEST(MeanInterval, OneValueHasNoInterval) {
  EXPECT_EQ(meanInterval({7}).mean, 7.0);
  EXPECT_EQ(meanInterval({7}).half_width, 0.0);
  EXPECT_EQ(meanInterval({}).count, 0u);
}

}  // namespace
}  // namespace dynemo::experiments
