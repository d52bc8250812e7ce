#include "dynemo/core/mrpt_conversions.h"

#include <gtest/gtest.h>
#include <mrpt/core/Clock.h>
#include <mrpt/core/exceptions.h>

#include <numbers>

#include "random_values.h"

namespace dynemo::test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(MrptConversions, PosesThereAndBack) {
  RandomValues random(1);
  for (int i = 0; i < 100; ++i) {
    const Pose3 T = random.pose(kPi);
    EXPECT_LT(local(fromMrpt(toMrpt(T)), T).norm(), 1e-12);
    const Pose3 S = random.pose(kPi);
    EXPECT_LT(local(fromMrpt(toMrpt(T) + toMrpt(S)), T * S).norm(), 1e-11) << "MRPT's + composes";
  }
}

TEST(MrptConversions, YawPitchRollMeansTheSame) {
  const mrpt::poses::CPose3D mrpt_pose(1, 2, 3, 0.4, -0.5, 0.6);
  EXPECT_LT(local(fromMrpt(mrpt_pose), Pose3::fromYawPitchRoll(1, 2, 3, 0.4, -0.5, 0.6)).norm(),
            1e-12);
}

TEST(MrptConversions, StampsOfTheUnixEpoch) {
  EXPECT_EQ(toMrpt(Stamp{0}), mrpt::Clock::fromDouble(0.0));
  EXPECT_NEAR(mrpt::Clock::toDouble(toMrpt(Stamp::parse("1700000030.1234567"))), 1700000030.1234567,
              1e-6);
  for (const std::int64_t ns : {0L, 100L, 1'700'000'030'123'456'700L, -12'345'600L}) {
    EXPECT_EQ(fromMrpt(toMrpt(Stamp{ns})).ns, ns) << "multiples of MRPT's tick survive";
  }
}

/// x, y, z, yaw, pitch, roll of a pose.
Vector6 yprOf(const Pose3& T) {
  const auto p = toMrpt(T);
  return (Vector6() << p.x(), p.y(), p.z(), p.yaw(), p.pitch(), p.roll()).finished();
}

TEST(MrptConversions, CovarianceByNumericDerivatives) {
  constexpr double kDifference = 1e-6;
  RandomValues random(2);
  for (int sample = 0; sample < 50; ++sample) {
    const Pose3 T = Pose3::fromYawPitchRoll(1, 2, 3, random.uniform(-3, 3),
                                            random.uniform(-1.3, 1.3), random.uniform(-3, 3));
    Matrix6 J;
    for (int i = 0; i < 6; ++i) {
      const Vector6 d = kDifference * Vector6::Unit(i);
      J.col(i) = (yprOf(T.retract(d)) - yprOf(T.retract(-d))) / (2 * kDifference);
    }
    const Matrix6 cov = random.spd(6), expected = J * cov * J.transpose();
    const auto actual = covarianceToMrpt(T, cov);
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) EXPECT_NEAR(actual(r, c), expected(r, c), 1e-7 * expected.norm());
    EXPECT_LT((covarianceFromMrpt(T, actual) - cov).norm(), 1e-9 * cov.norm());
    const auto gaussian = toMrptGaussian(T, cov);
    EXPECT_LT(local(fromMrpt(gaussian.mean), T).norm(), 1e-12);
    EXPECT_EQ(gaussian.cov(3, 4), actual(3, 4));
  }
}

TEST(MrptConversions, CovarianceLookingStraightUpIsFinite) {
  for (const double pitch : {kPi / 2, -kPi / 2}) {
    const Pose3 T = Pose3::fromYawPitchRoll(0, 0, 0, 0.3, pitch, 0.0);
    const auto cov = covarianceToMrpt(T, isotropicCovariance(0.1, 0.1));
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) EXPECT_TRUE(std::isfinite(cov(r, c)));
    EXPECT_TRUE(covarianceFromMrpt(T, cov).allFinite());
  }
}

TEST(MrptReason, IsOneLine) {
  try {
    THROW_EXCEPTION("the yaw is missing");
  } catch (const std::exception& e) {
    EXPECT_EQ(mrptReason(e), "the yaw is missing");
  }
  EXPECT_EQ(mrptReason(std::runtime_error("short\nlong")), "short");
}

}  // namespace
}  // namespace dynemo::test
