#include "dynemo/life/settling.h"

#include <gtest/gtest.h>

#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"
#include "object_tie.h"

namespace dynemo {
namespace {

using Track = std::vector<std::shared_ptr<CNodeEntity>>;

class Settling : public testing::Test {
 protected:
  static constexpr std::size_t kKeyframes = 150;

  /// An object that was seen in both laps that are older than the window.
  const Track& seenOften() const {
    const auto it =
        std::find_if(graph_.tracks().begin(), graph_.tracks().end(), [](const auto& track) {
          return track.second.front()->semantic_class == SemanticClass::kObject &&
                 track.second.size() >= 10;
        });
    return it->second;
  }
  bool isOld(const CNodeEntity& seen) const {
    const auto window = static_cast<std::size_t>(life_.window);
    return seen.keyframe < graph_.keyframes()[kKeyframes - window]->id;
  }
  NodeId tiedTo(const CNodeEntity& seen) const {
    const CEdgeIntraEntity* tie = life::tieOf(graph_, seen);
    return tie ? tie->nodes[0] : NodeId{};
  }
  void settle() { graph_.apply(settledTies(graph_, life_)); }

  LifeParams life_;
  CSceneGraph graph_ = test::generateGraph({}, kKeyframes);
};

TEST_F(Settling, TiesOldObservationsToTheFirst) {
  const std::size_t edges = graph_.edgeCount();
  settle();
  EXPECT_EQ(graph_.edgeCount(), edges);
  const MatrixX firmly = *invertSpd(isotropicCovariance(0.02, 0.035));  // generated_graph.cpp
  std::size_t old = 0, recent = 0;
  for (const auto& [entity, track] : graph_.tracks()) {
    if (track.front()->semantic_class == SemanticClass::kAgent) continue;
    for (std::size_t i = 1; i < track.size(); ++i) {
      const CEdgeIntraEntity* tie = life::tieOf(graph_, *track[i]);
      ASSERT_TRUE(tie);
      EXPECT_LT((tie->information() - firmly).norm(), 1e-9 * firmly.norm());
      EXPECT_EQ(tie->nodes[0], track[isOld(*track[i]) ? 0 : i - 1]->id);
      ++(isOld(*track[i]) ? old : recent);
    }
  }
  EXPECT_GT(old, 100u);
  EXPECT_GT(recent, 50u);
  EXPECT_TRUE(settledTies(graph_, life_).empty()) << "nothing is left to be settled";
}

TEST_F(Settling, AStayBeginsWhereTheObjectWasPutDown) {
  const Track& track = seenOften();
  ASSERT_TRUE(isOld(*track[5]));
  track[3]->moved = true;
  settle();
  EXPECT_EQ(tiedTo(*track[2]), track[0]->id);
  EXPECT_EQ(tiedTo(*track[3]), NodeId{});
  EXPECT_EQ(tiedTo(*track[4]), track[3]->id);
  EXPECT_EQ(tiedTo(*track[5]), track[3]->id);
}

TEST_F(Settling, WhatIsDoubtfulStaysDoubtful) {
  const Track& track = seenOften();
  const RobustKernel doubt = {KernelType::kCauchy, 2.0};
  graph_.edgeSlots()[life::tieOf(graph_, *track[3])->id.value]->kernel = doubt;
  settle();
  EXPECT_EQ(life::tieOf(graph_, *track[2])->kernel.type, KernelType::kNone);
  for (const std::size_t i : {3u, 4u, 5u})
    EXPECT_EQ(life::tieOf(graph_, *track[i])->kernel.type, KernelType::kCauchy) << i;
}

TEST_F(Settling, AgentsAreNotTied) {
  const auto edgesOfAgents = [this] {
    std::vector<EdgeId> ids;
    for (const auto& [entity, track] : graph_.tracks()) {
      if (track.front()->semantic_class != SemanticClass::kAgent) continue;
      for (const auto& seen : track)
        ids.insert(ids.end(), graph_.edgesOf(seen->id).begin(), graph_.edgesOf(seen->id).end());
    }
    return ids;
  };
  const auto before = edgesOfAgents();
  ASSERT_FALSE(before.empty());
  settle();
  EXPECT_EQ(edgesOfAgents(), before);
}

}  // namespace
}  // namespace dynemo
