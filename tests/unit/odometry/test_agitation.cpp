#include "dynemo/odometry/agitation.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

TEST(Agitation, FollowsTheChangesOfVelocity) {
  Agitation agitation(5.0, 10.0, 0.5);
  EXPECT_DOUBLE_EQ(agitation.linear_m_s2(), 5.0);
  const BodyTwist slow{{1, 0, 0}, {0, 0, 0.1}}, fast{{1.3, 0, 0}, {0, 0, 0.3}};
  for (int i = 0; i < 60; ++i) agitation.add(slow, fast, 0.1);
  EXPECT_NEAR(agitation.linear_m_s2(), 3.0, 1e-6);
  EXPECT_NEAR(agitation.angular_rad_s2(), 2.0, 1e-6);
  for (int i = 0; i < 60; ++i) agitation.add(fast, fast, 0.1);
  EXPECT_LT(agitation.linear_m_s2(), 1e-6);
}

}  // namespace
}  // namespace dynemo
