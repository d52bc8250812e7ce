#include "dynemo/life/keyframe_trail.h"

#include <gtest/gtest.h>

#include "dynemo/life/removal.h"
#include "generated_graph.h"

namespace dynemo {
namespace {

/// Of poses that have left.
constexpr double kRounding = 1e-5;

class Trail : public testing::Test {
 protected:
  void SetUp() override {
    graph_ = test::generateGraph({}, 60);
    for (const auto& keyframe : graph_.keyframes()) trail_.add(*keyframe);
  }
  void leave(const std::vector<std::size_t>& indices) {
    std::vector<NodeId> ids;
    for (const std::size_t i : indices) ids.push_back(ids_[i]);
    trail_.hang(ids, graph_);
    for (const NodeId id : ids) graph_.apply(removalOf(graph_, id, {}));
  }
  CSceneGraph graph_;
  KeyframeTrail trail_;
  const std::vector<NodeId> ids_ = [] {
    std::vector<NodeId> ids;
    const CSceneGraph graph = test::generateGraph({}, 60);
    for (const auto& keyframe : graph.keyframes()) ids.push_back(keyframe->id);
    return ids;
  }();
};

TEST_F(Trail, KeyframesOfTheGraphAreWhereTheyAre) {
  ASSERT_EQ(trail_.size(), 60u);
  for (std::size_t k = 0; k < 60; ++k) {
    EXPECT_EQ(trail_.T_map_base(k, graph_).t, graph_.keyframes()[k]->T_map_base().t);
    EXPECT_EQ(trail_.stamp(k), graph_.keyframes()[k]->stamp);
  }
}

TEST_F(Trail, OneThatLeavesStaysWhereItWas) {
  const Pose3 before = trail_.T_map_base(21, graph_);
  leave({20, 21, 22});
  EXPECT_EQ(trail_.left(), 3u);
  EXPECT_LT(local(before, trail_.T_map_base(21, graph_)).norm(), kRounding);
}

TEST_F(Trail, AndMovesWithTheMap) {
  leave({20, 21, 22});
  const Pose3 before = trail_.T_map_base(21, graph_);
  const Pose3 T_new_old = Pose3::fromYawPitchRoll(3, -2, 0.1, 0.4, 0.02, -0.01);
  for (const auto& keyframe : graph_.keyframes())
    keyframe->T_map_node = T_new_old * keyframe->T_map_node;
  EXPECT_LT(local(T_new_old * before, trail_.T_map_base(21, graph_)).norm(), kRounding);
}

TEST_F(Trail, AlsoWhereWhatItHangsOnLeavesLater) {
  const Pose3 before = trail_.T_map_base(21, graph_);
  leave({21});
  leave({19, 20, 22, 23});
  leave({17, 18, 24, 25, 26});
  EXPECT_LT(local(before, trail_.T_map_base(21, graph_)).norm(), kRounding);
}

TEST_F(Trail, UnknownKeyframesAndTheLastOneCannotLeave) {
  const std::vector<NodeId> unknown = {NodeId{1'000'000}};
  EXPECT_THROW(trail_.hang(unknown, graph_), std::out_of_range);
  std::vector<NodeId> all;
  for (const auto& keyframe : graph_.keyframes()) all.push_back(keyframe->id);
  EXPECT_THROW(trail_.hang(all, graph_), std::logic_error);
}

}  // namespace
}  // namespace dynemo
