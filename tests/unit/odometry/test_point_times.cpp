#include "dynemo/odometry/point_times.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

TEST(PointTimes, TheMiddleLiesBetweenTheFirstAndTheLastPoint) {
  PointCloud cloud;
  EXPECT_EQ(middleOfSweep(cloud), 0.0);
  cloud.time_offset_s = {0.0F, -0.04F, 0.02F, 0.06F};
  EXPECT_NEAR(middleOfSweep(cloud), 0.01, 1e-7);
}

}  // namespace
}  // namespace dynemo
