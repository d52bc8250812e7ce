#include "dynemo/evaluation/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace dynemo {
namespace {

constexpr double kTolerance = 1e-12;

TEST(Statistics, OfFourValuesByHand) {
  const Statistics s = summarize(std::vector<double>{4.0, 1.0, 2.0, 3.0});
  EXPECT_NEAR(s.rmse, std::sqrt(30.0 / 4.0), kTolerance);
  EXPECT_NEAR(s.mean, 2.5, kTolerance);
  EXPECT_NEAR(s.median, 2.5, kTolerance);
  EXPECT_NEAR(s.std, std::sqrt(5.0 / 4.0), kTolerance);
  EXPECT_EQ(s.min, 1.0);
  EXPECT_EQ(s.max, 4.0);
  EXPECT_EQ(s.count, 4u);
}

TEST(Statistics, MedianOfAnOddCountIsTheMiddle) {
  EXPECT_EQ(median(std::vector<double>{9.0, 1.0, 5.0}), 5.0);
}

TEST(Statistics, OfNothingIsNotANumber) {
  const Statistics s = summarize(std::vector<double>{});
  EXPECT_EQ(s.count, 0u);
  EXPECT_TRUE(std::isnan(s.rmse));
  EXPECT_TRUE(std::isnan(s.median));
}

}  // namespace
}  // namespace dynemo
