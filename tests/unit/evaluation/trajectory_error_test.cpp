#include "dynemo/evaluation/trajectory_error.h"

#include <gtest/gtest.h>

#include <numbers>

#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-9;

TEST(AbsoluteError, IsZeroUnderAnyRigidMotionOfTheEstimate) {
  const Trajectory reference = curve(80);
  const Pose3 T = Pose3::fromYawPitchRoll(-5, 8, 1, -2.0, 0.3, 0.9);
  for (const Pose3& shift : {Pose3(), T, T.inverse()}) {
    const auto aligned = alignTrajectories(reference, transformed(reference, shift));
    ASSERT_TRUE(aligned);
    EXPECT_LT(absoluteTranslationError(*aligned).max, kTolerance);
    EXPECT_LT(local(shift.inverse(), aligned->T_reference_estimate).norm(), kTolerance);
  }
}

TEST(AbsoluteError, OfASquareWithOneLiftedPairByHand) {
  // Diagonal corners lifted by ±h in alternation: no rigid motion lowers the error, every distance
  // is h.
  constexpr double kLift_m = 0.25;
  Trajectory reference, estimate;
  const double x[] = {1, -1, -1, 1}, y[] = {1, 1, -1, -1};
  for (int i = 0; i < 4; ++i) {
    reference.push_back({at(i), Pose3::translation(x[i], y[i], 0)});
    estimate.push_back({at(i), Pose3::translation(x[i], y[i], i % 2 ? kLift_m : -kLift_m)});
  }
  const auto aligned = alignTrajectories(reference, estimate);
  ASSERT_TRUE(aligned);
  const Statistics ate = absoluteTranslationError(*aligned);
  EXPECT_NEAR(ate.rmse, kLift_m, kTolerance);
  EXPECT_NEAR(ate.max, kLift_m, kTolerance);
  EXPECT_NEAR(ate.std, 0.0, kTolerance);
  EXPECT_EQ(ate.count, 4u);
}

AlignedTrajectories alongX(int count, double step_m, double drift) {
  AlignedTrajectories aligned;
  for (int i = 0; i < count; ++i) {
    aligned.reference.push_back({at(i), Pose3::translation(step_m * i, 0, 0)});
    aligned.estimate.push_back({at(i), Pose3::translation(step_m * i * (1.0 + drift), 0, 0)});
  }
  return aligned;
}

TEST(RelativeError, OverOneMeterOfAStraightLineByHand) {
  // Steps of 0.25 m drawn out by 4 %: four steps of the estimate make 1.04 m, within the tolerance
  // of 1 m.
  const auto errors =
      relativePoseErrors(alongX(9, 0.25, 0.04), {RelativePoseParams::Unit::kMeters, 1.0});
  EXPECT_EQ(errors.translation_m.count, 5u);
  EXPECT_NEAR(errors.translation_m.rmse, 0.04, kTolerance);
  EXPECT_NEAR(errors.rotation_rad.max, 0.0, kTolerance);
}

TEST(RelativeError, LeavesOutPairsBeyondTheTolerance) {
  const auto errors =
      relativePoseErrors(alongX(9, 0.7, 0.0), {RelativePoseParams::Unit::kMeters, 1.0});
  EXPECT_EQ(errors.translation_m.count, 0u);
}

TEST(RelativeError, PerFrameByHand) {
  auto aligned = alongX(4, 0.5, 0.0);
  aligned.estimate[2].T = Pose3::fromYawPitchRoll(1.0, 0.3, 0, std::numbers::pi / 6, 0, 0);
  const auto errors = relativePoseErrors(aligned, {RelativePoseParams::Unit::kFrames, 1.0});
  EXPECT_EQ(errors.translation_m.count, 3u);
  EXPECT_NEAR(errors.translation_m.min, 0.0, kTolerance);
  EXPECT_NEAR(errors.rotation_rad.max, std::numbers::pi / 6, kTolerance);
  EXPECT_NEAR(errors.rotation_rad.median, std::numbers::pi / 6, kTolerance);
  EXPECT_NEAR(errors.translation_m.median, 0.3, kTolerance);
}

TEST(RelativeError, AStandingRobotIsPairedWithItsFirstArrival) {
  AlignedTrajectories aligned;
  const double x[] = {0, 1, 1, 1};
  for (int i = 0; i < 4; ++i) {
    aligned.reference.push_back({at(i), Pose3::translation(x[i], 0.1 * i, 0)});
    aligned.estimate.push_back({at(i), Pose3::translation(x[i], 0, 0)});
  }
  const auto errors = relativePoseErrors(aligned, {RelativePoseParams::Unit::kMeters, 1.0});
  ASSERT_EQ(errors.translation_m.count, 1u);
  EXPECT_NEAR(errors.translation_m.max, 0.1, kTolerance);
}

}  // namespace
}  // namespace dynemo::test
