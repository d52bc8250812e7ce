#include "agent_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynemo/core/noise.h"

namespace dynemo::test {
namespace {

TEST(AgentMotion, IsTheIntegralOfTheVelocitysAutocorrelation) {
  const QueryParams params;
  for (const double t : {1e-4, 0.01, 0.5, 3.0, 40.0}) {
    constexpr int kSteps = 100'000;
    double integral = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double s = t * (i + 0.5) / kSteps;
      integral += 2.0 * (t - s) * std::exp(-s / params.agent_persistence_s) * t / kSteps;
    }
    const double expected = params.agent_speed_mps * params.agent_speed_mps * integral;
    EXPECT_NEAR(displacementVariance(t, params), expected, 1e-4 * expected) << t;
  }
  EXPECT_EQ(displacementVariance(0.0, params), 0.0);
}

TEST(AgentMotion, HeadingEndsUniform) {
  const QueryParams params;
  EXPECT_EQ(headingVariance(0.0, params), 0.0);
  EXPECT_NEAR(headingVariance(1e3, params), std::numbers::pi * std::numbers::pi / 3.0, 1e-9);
}

TEST(AgentMotion, GrowsInTheMapsPlane) {
  // An entity on its side: its own y axis is the map's z.
  const Pose3 T = Pose3::fromYawPitchRoll(0, 0, 0, 0.3, 0.0, std::numbers::pi / 2);
  const Matrix6 grown = withMotion(Matrix6::Zero(), T.R, 4.0, 0.25);
  const Matrix3 in_map = T.R * grown.topLeftCorner<3, 3>() * T.R.transpose();
  EXPECT_LT((in_map - Matrix3(Vector3(4, 4, 0).asDiagonal())).norm(), 1e-12);
  EXPECT_EQ(grown(5, 5), 0.25);
}

TEST(AgentMotion, ProbabilityWithin) {
  EXPECT_EQ(probabilityWithin(0.5, 0.0), 1.0);
  // The median of a Rayleigh distribution.
  EXPECT_NEAR(probabilityWithin(std::sqrt(2.0 * std::log(2.0)), 1.0), 0.5, 1e-12);
}

}  // namespace
}  // namespace dynemo::test
