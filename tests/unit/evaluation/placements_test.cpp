#include "dynemo/evaluation/placements.h"

#include <gtest/gtest.h>

#include "example_run.h"

namespace dynemo::test {
namespace {

TEST(Placements, OfAnObjectThatJumpsOnce) {
  const auto placements = findPlacements(exampleTruths().at({1}).poses);
  ASSERT_EQ(placements.size(), 2u);
  EXPECT_EQ(placements[0].begin, at(0));
  EXPECT_EQ(placements[0].end, at(9.999999));
  EXPECT_EQ(placements[1].begin, at(10));
  EXPECT_EQ(placementAt(placements, at(9.0)), 0u);
  EXPECT_EQ(placementAt(placements, at(10.0)), 1u);
  EXPECT_FALSE(placementAt(placements, at(21.0)));
}

TEST(Placements, ASlideBelongsToNone) {
  Trajectory truth = {{at(0), Pose3()}};
  for (int i = 0; i <= 10; ++i)
    truth.push_back({at(5 + 0.1 * i), Pose3::translation(0.1 * i, 0, 0)});
  truth.push_back({at(9), truth.back().T});
  const auto placements = findPlacements(truth);
  ASSERT_EQ(placements.size(), 2u);
  EXPECT_FALSE(placementAt(placements, at(5.5)));
  EXPECT_EQ(placementAt(placements, at(6.0)), 1u);
}

TEST(Placements, ATurnOnTheSpotEndsOne) {
  const Pose3 T_turned = Pose3::fromYawPitchRoll(0, 0, 0, 0.5, 0, 0);
  const Trajectory truth = {
      {at(0), Pose3()}, {at(4), Pose3()}, {at(4.1), T_turned}, {at(8), T_turned}};
  EXPECT_EQ(findPlacements(truth).size(), 2u);
}

TEST(Placements, OfSomethingThatAlwaysMovesAreNone) {
  EXPECT_TRUE(findPlacements(curve(50)).empty());
  EXPECT_TRUE(findPlacements({}).empty());
}

}  // namespace
}  // namespace dynemo::test
