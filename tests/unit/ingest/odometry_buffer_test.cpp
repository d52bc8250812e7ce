#include "dynemo/ingest/odometry_buffer.h"

#include <gtest/gtest.h>

#include "dynemo/core/noise.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using test::at;
using test::truePose;

constexpr double kExact = 1e-9;
/// Half a step of 0.1 s on the circle of truePose.
constexpr double kChord = 2e-3;

OdometryState state(double seconds) {
  return {truePose(seconds), isotropicCovariance(0.1 * seconds, 0.01)};
}

OdometryBuffer filled(const OdometrySensorParams& params) {
  OdometryBuffer buffer(params);
  for (int i = 0; i <= 20; ++i) buffer.push(at(0.1 * i), state(0.1 * i));
  return buffer;
}

TEST(OdometryBuffer, IsExactAtSamplesAndInterpolatesBetween) {
  const auto buffer = filled({});
  EXPECT_LT(local(truePose(0.7), buffer.at(at(0.7))->T_odom_base).norm(), kExact);
  const auto between = buffer.at(at(0.73));
  ASSERT_TRUE(between);
  EXPECT_LT(local(truePose(0.73), between->T_odom_base).norm(), kChord);
  const double expected = 0.7 * 0.07 * 0.07 + 0.3 * 0.08 * 0.08;
  EXPECT_NEAR((*between->accumulated_covariance)(0, 0), expected, kExact);
}

TEST(OdometryBuffer, ContinuesAtConstantVelocityForAShortTime) {
  const auto buffer = filled({});
  for (const double t : {2.08, -0.08}) {
    const auto beyond = buffer.at(at(t));
    ASSERT_TRUE(beyond) << t;
    EXPECT_LT(local(truePose(t), beyond->T_odom_base).norm(), 2 * kChord) << t;
    const double standing = local(truePose(t < 0 ? 0.0 : 2.0), truePose(t)).norm();
    EXPECT_GT(standing, 10 * kChord) << "the check must tell it from standing still";
  }
  EXPECT_FALSE(buffer.at(at(2.2)));
  EXPECT_FALSE(buffer.at(at(-0.2)));
}

TEST(OdometryBuffer, DoesNotBridgeLongGaps) {
  OdometrySensorParams params;
  OdometryBuffer buffer(params);
  for (const double t : {0.0, 0.1, 1.1, 1.2}) buffer.push(at(t), state(t));
  EXPECT_TRUE(buffer.at(at(0.15)));
  EXPECT_FALSE(buffer.at(at(0.6)));
  EXPECT_TRUE(buffer.at(at(1.05)));
  EXPECT_LT(local(truePose(1.05), buffer.at(at(1.05))->T_odom_base).norm(), 2 * kChord);
}

TEST(OdometryBuffer, OneSampleStandsStill) {
  OdometryBuffer buffer({});
  EXPECT_FALSE(buffer.at(at(0)));
  buffer.push(at(0), state(0));
  EXPECT_LT(local(truePose(0), buffer.at(at(0.05))->T_odom_base).norm(), kExact);
}

TEST(OdometryBuffer, RefusesStampsThatDoNotIncrease) {
  auto buffer = filled({});
  EXPECT_FALSE(buffer.push(at(2.0), state(2.0)));
  EXPECT_FALSE(buffer.push(at(1.0), state(1.0)));
  EXPECT_EQ(buffer.size(), 21U);
}

TEST(OdometryBuffer, ForgettingKeepsWhatIsNeeded) {
  auto buffer = filled({});
  const auto before = buffer.at(at(1.01));
  buffer.forgetBefore(at(1.0));
  EXPECT_LE(buffer.size(), 13U);
  const auto after = buffer.at(at(1.01));
  ASSERT_TRUE(after);
  EXPECT_LT(local(before->T_odom_base, after->T_odom_base).norm(), kExact);
}

}  // namespace
}  // namespace dynemo
