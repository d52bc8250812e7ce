#include "dynemo/evaluation/entity_change.h"

#include <gtest/gtest.h>

#include <cmath>

#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-9;

const Pose3 kSecondPlace = Pose3::fromYawPitchRoll(2, 0, 0, 1.0, 0, 0);

EntityErrors errorsOf(const std::vector<EntityEstimate>& estimates) {
  return evaluateEntities(estimates, exampleTruths(), Pose3());
}

EntityEstimate flagged(EntityEstimate e) {
  e.moved = true;
  return e;
}

TEST(DetectionCounts, ByHand) {
  const DetectionCounts c{3, 1, 2};
  EXPECT_NEAR(c.precision(), 0.75, kTolerance);
  EXPECT_NEAR(c.recall(), 0.6, kTolerance);
  EXPECT_NEAR(c.f1(), 2 * 0.75 * 0.6 / 1.35, kTolerance);
  EXPECT_EQ(DetectionCounts().f1(), 1.0);
}

TEST(Changes, ARightReport) {
  const auto report = evaluateChanges(
      errorsOf({estimate(0, 1, 1, {}), flagged(estimate(1, 1, 12, kSecondPlace)),
                estimate(2, 1, 15, kSecondPlace), estimate(3, 2, 2, Pose3::translation(0, 5, 0)),
                estimate(4, 2, 16, Pose3::translation(0, 5, 0))}),
      exampleTruths());
  ASSERT_EQ(report.objects.size(), 2u);
  EXPECT_TRUE(report.objects[0].truly_moved && report.objects[0].reported_moved);
  EXPECT_FALSE(report.objects[1].truly_moved || report.objects[1].reported_moved);
  EXPECT_EQ(report.by_object.f1(), 1.0);
  EXPECT_EQ(report.by_observation.true_positives, 1u);
  EXPECT_EQ(report.by_observation.f1(), 1.0);
  EXPECT_EQ(report.objects_at_end.true_positives, 2u);
}

TEST(Changes, AMissAFalseAlarmAndAnObjectLeftBehind) {
  const auto report =
      evaluateChanges(errorsOf({estimate(0, 1, 1, {}), estimate(1, 1, 12, {}),
                                estimate(2, 2, 2, Pose3::translation(0, 5, 0)),
                                flagged(estimate(3, 2, 9, Pose3::translation(0, 5, 0)))}),
                      exampleTruths());
  EXPECT_EQ(report.by_object.false_negatives, 1u);
  EXPECT_EQ(report.by_object.false_positives, 1u);
  EXPECT_EQ(report.by_object.true_positives, 0u);
  EXPECT_EQ(report.objects_at_end.true_positives, 1u);
  EXPECT_EQ(report.objects_at_end.false_positives, 1u);
  EXPECT_EQ(report.objects_at_end.false_negatives, 1u);
}

TEST(Changes, AMoveBeforeTheFirstObservationIsNone) {
  const auto report = evaluateChanges(
      errorsOf({estimate(0, 1, 12, kSecondPlace), estimate(1, 1, 15, kSecondPlace)}),
      exampleTruths());
  EXPECT_FALSE(report.objects[0].truly_moved);
  EXPECT_EQ(report.objects_at_end.false_negatives, 1u);  // object 2 was never seen
}

TEST(Changes, LeaveAgentsOut) {
  auto a = estimate(0, 101, 1, Pose3::translation(1, 0, 0)),
       b = estimate(1, 101, 9, Pose3::translation(9, 0, 0));
  a.semantic_class = b.semantic_class = SemanticClass::kAgent;
  EXPECT_TRUE(evaluateChanges(errorsOf({a, flagged(b)}), exampleTruths()).objects.empty());
}

TEST(Motions, AreRightWhenThePosesShareOneOffsetInTheWorld) {
  // The whole world shifted: every motion H stays what it is.
  const Vector3 shift(0.5, -0.25, 0);
  const auto errors = errorsOf({estimate(0, 1, 1, Pose3::translation(shift)),
                                estimate(1, 1, 12, Pose3(kSecondPlace.R, kSecondPlace.t + shift))});
  const MotionErrors motions = evaluateMotions(errors, SemanticClass::kObject);
  ASSERT_EQ(motions.rme.translation_m.count, 1u);
  // H turns by 1 rad about the origin, so that the shift reappears as |(I − R) shift| = 2 sin(1/2)
  // |shift|.
  const double expected_m = 2.0 * std::sin(0.5) * shift.norm();
  EXPECT_NEAR(motions.me.translation_m.max, expected_m, kTolerance);
  EXPECT_NEAR(motions.rme.translation_m.max, expected_m, kTolerance);
  EXPECT_NEAR(motions.me.rotation_rad.max, 0.0, 1e-7);
}

TEST(Motions, OnlyTheWorldFrameErrorGrowsWithTheDistance) {
  // Object 2 stands 5 m from the origin; its second estimate is turned by 0.1 rad.
  const auto errors = errorsOf({estimate(0, 2, 1, Pose3::translation(0, 5, 0)),
                                estimate(1, 2, 2, Pose3::fromYawPitchRoll(0, 5, 0, 0.1, 0, 0))});
  const MotionErrors motions = evaluateMotions(errors, SemanticClass::kObject);
  EXPECT_NEAR(motions.me.translation_m.max, 2.0 * std::sin(0.05) * 5.0, kTolerance);
  EXPECT_NEAR(motions.rme.translation_m.max, 0.0, kTolerance);
  EXPECT_NEAR(motions.rme.rotation_rad.max, 0.1, kTolerance);
}

TEST(Motions, FollowTheStampsNotTheOrderOfTheRows) {
  const auto errors = errorsOf({estimate(0, 1, 12, kSecondPlace), estimate(1, 1, 1, {})});
  const MotionErrors motions = evaluateMotions(errors, SemanticClass::kObject);
  EXPECT_NEAR(motions.me.translation_m.max, 0.0, kTolerance);
}

}  // namespace
}  // namespace dynemo::test
