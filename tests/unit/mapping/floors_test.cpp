#include "dynemo/mapping/floors.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

constexpr double kBase_m = 0.4;

class Floors : public ::testing::Test {
 protected:
  NodeId addFloor(double level_m) {
    auto floor = std::make_shared<CNodeFloor>();
    floor->level_m = level_m;
    return add(floor);
  }
  void addKeyframe(double ground_m, std::optional<NodeId> floor) {
    auto keyframe = std::make_shared<CNodeKeyframe>();
    keyframe->T_map_node = Pose3::translation(0, 0, ground_m + kBase_m);
    keyframe->floor = floor;
    add(keyframe);
  }
  FloorChoice choose(double ground_m, std::optional<GroundLevel> seen = std::nullopt) const {
    return chooseFloor(graph_, Pose3::translation(0, 0, ground_m + kBase_m), seen, params_);
  }
  NodeId add(const CNodeBase::Ptr& node) {
    node->id = graph_.nextNodeId();
    GraphDelta delta;
    delta.nodes = {node};
    graph_.apply(delta);
    return node->id;
  }

  CSceneGraph graph_;
  FloorParams params_;
};

TEST_F(Floors, TheFirstGroundSeenIsTheFirstFloor) {
  EXPECT_FALSE(baseHeight(graph_));
  EXPECT_FALSE(choose(0.0).new_level_m) << "nothing is known of the ground";
  const FloorChoice choice = choose(0.0, GroundLevel{-0.02, 0.0});
  EXPECT_FALSE(choice.floor);
  EXPECT_EQ(choice.new_level_m, -0.02);
}

TEST_F(Floors, TheHeightOfTheBaseTellsTheFloorWhereNoGroundIsSeen) {
  const NodeId lower = addFloor(0.0);
  addKeyframe(0.0, lower);
  EXPECT_NEAR(*baseHeight(graph_), kBase_m, 1e-12);
  ASSERT_TRUE(choose(0.3).floor);
  EXPECT_EQ(choose(0.3).floor->id, lower);
  EXPECT_FALSE(choose(0.8).floor) << "on the stairs";
  EXPECT_FALSE(choose(0.8).new_level_m);
}

TEST_F(Floors, ANewStoreyNeedsLevelGroundAStoreyAwayAndARobotThatClimbsNoMore) {
  const NodeId lower = addFloor(0.0);
  addKeyframe(0.0, lower);
  addKeyframe(2.2, std::nullopt);
  EXPECT_FALSE(choose(3.0, GroundLevel{3.0, 0.0}).new_level_m) << "still climbing";
  addKeyframe(3.0, std::nullopt);
  EXPECT_FALSE(choose(3.0).new_level_m) << "no ground seen";
  EXPECT_FALSE(choose(3.0, GroundLevel{3.0, 0.1}).new_level_m) << "a ramp";
  EXPECT_EQ(choose(3.0, GroundLevel{2.98, 0.0}).new_level_m, 2.98);
  addKeyframe(1.5, std::nullopt);
  EXPECT_FALSE(choose(1.5, GroundLevel{1.5, 0.0}).new_level_m) << "a landing";
}

TEST_F(Floors, AKnownStoreyIsFoundAgainAfterDrift) {
  const NodeId lower = addFloor(0.0), upper = addFloor(3.0);
  addKeyframe(0.0, lower);
  addKeyframe(3.0, upper);
  const FloorChoice back = choose(0.15, GroundLevel{0.15, 0.0});
  ASSERT_TRUE(back.floor);
  EXPECT_EQ(back.floor->id, lower);
  EXPECT_FALSE(back.new_level_m);
  ASSERT_TRUE(choose(2.8).floor);
  EXPECT_EQ(choose(2.8).floor->id, upper);
}

}  // namespace
}  // namespace dynemo
