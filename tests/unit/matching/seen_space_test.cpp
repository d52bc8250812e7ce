#include "dynemo/matching/seen_space.h"

#include <gtest/gtest.h>

#include "dynemo/matching/assess_match.h"
#include "dynemo/matching/matching_params.h"
#include "scan_pair.h"

namespace dynemo {
namespace {

/// A wall at x = 5 m, two by two metres.
std::vector<Eigen::Vector3f> wall(float x) {
  std::vector<Eigen::Vector3f> points;
  for (float y = -1.0F; y <= 1.0F; y += 0.1F) {
    for (float z = -1.0F; z <= 1.0F; z += 0.1F) points.emplace_back(x, y, z);
  }
  return points;
}

TEST(SeenSpace, PointsInFrontOfWhatWasSeenContradictIt) {
  const SeenSpace space(wall(5.0F), Eigen::Vector3f::Zero());
  EXPECT_EQ(space.contradicted(wall(5.0F), Pose3()), 0.0);
  EXPECT_EQ(space.contradicted(wall(4.8F), Pose3()), 0.0) << "within the margin";
  EXPECT_GT(space.contradicted(wall(5.0F), Pose3::translation(-2, 0, 0)), 0.9);
}

TEST(SeenSpace, WhatIsBehindOrOutOfViewSaysNothing) {
  const SeenSpace space(wall(5.0F), Eigen::Vector3f::Zero());
  EXPECT_EQ(space.contradicted(wall(5.0F), Pose3::translation(3, 0, 0)), 0.0);
  EXPECT_EQ(space.contradicted(wall(5.0F), Pose3::fromYawPitchRoll(0, 0, 0, 3.0, 0, 0)), 0.0);
  EXPECT_EQ(SeenSpace({}, Eigen::Vector3f::Zero()).contradicted(wall(1.0F), Pose3()), 0.0);
}

TEST(SeenSpace, LooksFromTheSensor) {
  const SeenSpace space(wall(5.0F), {3.0F, 0.0F, 0.0F});
  EXPECT_EQ(space.contradicted(wall(2.0F), Pose3()), 0.0) << "behind the sensor's back";
  EXPECT_GT(space.contradicted(wall(4.0F), Pose3()), 0.9);
}

TEST(AssessMatch, RefusesAPoseThatFreeSpaceContradicts) {
  const test::ScanPair pair = test::roomPair();
  const MatchingParams params;
  const MatchScan target(pair.target, params.scan), source(pair.source, params.scan);
  const auto right = assessMatch(target, source, pair.T_target_source, 0, params.assessment);
  ASSERT_TRUE(right) << toString(right.error());
  EXPECT_LT(right->contradiction, 0.05);
  const auto wrong = assessMatch(
      target, source, pair.T_target_source * Pose3::translation(-2, 1.5, 0), 0, params.assessment);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error(), MatchFailure::kContradicted);
}

}  // namespace
}  // namespace dynemo
