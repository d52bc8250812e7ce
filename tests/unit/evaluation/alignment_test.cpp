#include "dynemo/evaluation/alignment.h"

#include <gtest/gtest.h>

#include "dynemo/evaluation/trajectory_error.h"
#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-12;

std::vector<Vector3> positions(const Trajectory& trajectory) {
  std::vector<Vector3> list;
  for (const auto& pose : trajectory) list.push_back(pose.T.t);
  return list;
}

TEST(Associate, TakesTheNearestForEachStampOfTheShorterList) {
  const Trajectory reference = {{at(0.0), {}}, {at(0.1), {}}, {at(0.2), {}}, {at(0.3), {}}};
  const Trajectory estimate = {{at(0.104), {}}, {at(0.292), {}}, {at(0.25), {}}};
  const auto pairs = associate(reference, estimate, 0.01);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].reference, 1u);
  EXPECT_EQ(pairs[0].estimate, 0u);
  EXPECT_EQ(pairs[1].reference, 3u);
  EXPECT_EQ(pairs[1].estimate, 1u);
}

TEST(Associate, WorksFromTheReferenceWhenThatIsShorter) {
  const Trajectory reference = {{at(0.1), {}}};
  const Trajectory estimate = {{at(0.0), {}}, {at(0.1001), {}}};
  const auto pairs = associate(reference, estimate, 0.01);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].reference, 0u);
  EXPECT_EQ(pairs[0].estimate, 1u);
}

TEST(Associate, AcceptsTheMaximalDifferenceItself) {
  const Trajectory reference = {{at(0.0), {}}}, estimate = {{at(0.01), {}}};
  EXPECT_EQ(associate(reference, estimate, 0.01).size(), 1u);
  EXPECT_TRUE(associate(reference, estimate, 0.0099).empty());
  EXPECT_TRUE(associate({}, {}, 0.01).empty());
}

class AlignPoints : public ::testing::TestWithParam<bool> {};

/// Forward and with the roles exchanged.
TEST_P(AlignPoints, FindsTheMotionBetweenShiftedCurves) {
  const Pose3 T_a_b = Pose3::fromYawPitchRoll(10, -20, 3, 2.5, -0.7, 0.4);
  const Trajectory b = curve(60), a = transformed(b, T_a_b);
  const bool forward = GetParam();
  const auto found =
      forward ? alignPoints(positions(a), positions(b)) : alignPoints(positions(b), positions(a));
  ASSERT_TRUE(found);
  EXPECT_LT(local(forward ? T_a_b : T_a_b.inverse(), *found).norm(), kTolerance);
}

INSTANTIATE_TEST_SUITE_P(BothWays, AlignPoints, ::testing::Bool());

TEST(AlignPoints, OfAPlanarCurveIsARotationNotAReflection) {
  Trajectory flat = curve(40);
  for (auto& pose : flat) pose.T.t.z() = 0.0;
  const Pose3 T = Pose3::fromYawPitchRoll(0, 0, 1, 0.0, 3.0, 0.0);
  const auto found = alignPoints(positions(transformed(flat, T)), positions(flat));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->R.determinant(), 1.0, kTolerance);
  EXPECT_LT(local(T, *found).norm(), kTolerance);
}

TEST(AlignPoints, RefusesWhatDeterminesNoRotation) {
  std::vector<Vector3> line, point(5, Vector3(1, 2, 3));
  for (int i = 0; i < 5; ++i) line.emplace_back(i, 2.0 * i, 0.0);
  EXPECT_EQ(alignPoints(line, line).error(), AlignmentFailure::kDegenerate);
  EXPECT_EQ(alignPoints(point, point).error(), AlignmentFailure::kDegenerate);
  EXPECT_EQ(alignPoints({}, {}).error(), AlignmentFailure::kTooFewPoints);
}

}  // namespace
}  // namespace dynemo::test
