// What two keyframes that see the same entities make of them: consensus and prefilters.
#include <gtest/gtest.h>

#include "dynemo/loops/entity_prefilter.h"
#include "loop_graph.h"

namespace dynemo {
namespace {

const Pose3 kMoved = Pose3::translation(0.5, 0.2, 0);
constexpr SemanticClass kAgent = SemanticClass::kAgent;

/// Keyframes 0 and 1, the later a little off by drift; objects 1 … 4 and agent 101.
class EntityPairs : public testing::Test {
 protected:
  EntityPairs() { drive_.addKeyframe(); }

  static Pose3 place(int id) { return Pose3::fromYawPitchRoll(2.0 + id, 1.0 - id, 0.3, id, 0, 0); }
  /// Of each entity: ten points of its own in either scan.
  static PointIndices fragment(int id) {
    PointIndices points;
    for (std::uint32_t i = 0; i < 10; ++i)
      points.push_back(static_cast<std::uint32_t>(id) * 10 + i);
    return points;
  }
  void see(int id, const Pose3& T_map_entity, SemanticClass c = SemanticClass::kObject) {
    drive_.see({id}, T_map_entity, c, fragment(id));
  }
  LoopPair pair() {
    LoopPair pair;
    pair.candidate = {0, 1, LoopOrigin::kDistance, 0, 0};
    pair.earlier = drive_.graph.keyframes()[0].get();
    pair.later = drive_.graph.keyframes()[1].get();
    pair.predicted = {drive_.trueRelative(0, 1), isotropicCovariance(0.05, 0.02)};
    pair.shared = sharedEntities(drive_.graph, *pair.earlier, *pair.later);
    pair.consensus = findConsensus(pair.shared, evidence_);
    return pair;
  }
  FilteredPair filter(const std::string& method) {
    prefilter_.method = method;
    const LoopPair p = pair();
    return entityPrefilters().make(method, prefilter_)->filter(drive_.graph, p, p.predicted);
  }
  static std::vector<std::int64_t> removed(const FilteredPair& filtered) {
    std::vector<std::int64_t> ids;
    for (const EntityDecision& d : filtered.entities) {
      if (d.removed) ids.push_back(d.entity.value);
    }
    return ids;
  }
  using Ids = std::vector<std::int64_t>;

  EntityEvidenceParams evidence_;
  PrefilterParams prefilter_;
  test::LoopGraph drive_;
};

TEST_F(EntityPairs, ConsensusIsTheRelativePose) {
  for (int id : {1, 2, 3}) see(id, place(id));
  drive_.addKeyframe();
  for (int id : {1, 2, 3}) see(id, place(id));
  const auto consensus = pair().consensus;
  ASSERT_TRUE(consensus);
  EXPECT_EQ(consensus->members, (std::vector<EntityId>{{1}, {2}, {3}}));
  EXPECT_LT(local(drive_.trueRelative(0, 1), consensus->earlier_later.T).norm(), 1e-6);
}

TEST_F(EntityPairs, ConsensusLeavesOutWhatMoved) {
  for (int id : {1, 2, 3}) see(id, place(id));
  drive_.addKeyframe();
  for (int id : {1, 2}) see(id, place(id));
  see(3, kMoved * place(3));
  const auto consensus = pair().consensus;
  ASSERT_TRUE(consensus);
  EXPECT_EQ(consensus->members, (std::vector<EntityId>{{1}, {2}}));
}

TEST_F(EntityPairs, ConsensusTakesSeveralObjectsAndNoAgents) {
  see(1, place(1));
  see(101, place(101), kAgent);
  drive_.addKeyframe();
  see(1, place(1));
  see(101, place(101), kAgent);
  EXPECT_FALSE(pair().consensus);
}

TEST_F(EntityPairs, NoneLeavesTheScans) {
  see(1, place(1));
  drive_.addKeyframe();
  see(1, kMoved * place(1));
  const FilteredPair filtered = filter("none");
  EXPECT_TRUE(filtered.removed_earlier.empty() && filtered.removed_later.empty());
}

TEST_F(EntityPairs, AlwaysRemovesEveryEntityFromWhereItIsRegistered) {
  see(1, place(1));
  drive_.addKeyframe();
  see(1, place(1));
  see(2, place(2));
  const FilteredPair filtered = filter("always");
  EXPECT_EQ(filtered.removed_earlier, fragment(1));
  EXPECT_EQ(filtered.removed_later.size(), 20u);
  EXPECT_EQ(removed(filtered), (Ids{1, 2}));
}

TEST_F(EntityPairs, MotionRemovesExactlyWhatMoved) {
  for (int id : {1, 2, 3}) see(id, place(id));
  drive_.addKeyframe();
  for (int id : {1, 3}) see(id, place(id));
  see(2, kMoved * place(2));
  const FilteredPair filtered = filter("motion");
  EXPECT_EQ(removed(filtered), (Ids{2}));
  EXPECT_EQ(filtered.removed_earlier, fragment(2));
  EXPECT_EQ(filtered.removed_later, fragment(2));
}

TEST_F(EntityPairs, MotionNeedsBothThresholdAndSignificance) {
  see(1, place(1));
  drive_.addKeyframe();
  see(1, kMoved * place(1));
  ASSERT_EQ(removed(filter("motion")), (Ids{1}));
  prefilter_.min_motion_m = 1.0;
  EXPECT_TRUE(removed(filter("motion")).empty());
  prefilter_.min_motion_m = 0.3;
  LoopPair uncertain = pair();
  uncertain.predicted.covariance = isotropicCovariance(0.3, 0.1);
  EXPECT_TRUE(removed(entityPrefilters()
                          .make("motion", prefilter_)
                          ->filter(drive_.graph, uncertain, uncertain.predicted))
                  .empty());
}

TEST_F(EntityPairs, TurningIsMotion) {
  see(1, place(1));
  drive_.addKeyframe();
  see(1, place(1) * Pose3::fromYawPitchRoll(0, 0, 0, 0.5, 0, 0));
  EXPECT_EQ(removed(filter("motion")), (Ids{1}));
}

TEST_F(EntityPairs, UnderTheCommonDisplacementOfAllNoneHasMoved) {
  for (int id : {1, 2, 3}) see(id, place(id));
  drive_.addKeyframe();
  for (int id : {1, 2, 3}) see(id, kMoved * place(id));
  const LoopPair p = pair();
  const auto motion = entityPrefilters().make("motion", prefilter_);
  EXPECT_EQ(removed(motion->filter(drive_.graph, p, p.predicted)), (Ids{1, 2, 3}));
  ASSERT_TRUE(p.consensus);
  EXPECT_TRUE(removed(motion->filter(drive_.graph, p, p.consensus->earlier_later)).empty());
}

TEST_F(EntityPairs, AgentsGoAlwaysOrAsObjectsDo) {
  see(101, place(101), kAgent);
  drive_.addKeyframe();
  see(101, place(101), kAgent);
  see(102, place(102), kAgent);
  EXPECT_EQ(removed(filter("motion")), (Ids{101, 102}));
  prefilter_.agents = AgentRemoval::kByMotion;
  EXPECT_TRUE(removed(filter("motion")).empty());
}

TEST_F(EntityPairs, TheTrackTellsOfAnObjectThatOnlyOneKeyframeSees) {
  see(1, place(1));
  drive_.addKeyframe();
  drive_.addKeyframe();
  see(1, kMoved * place(1));
  LoopPair p = pair();
  p.later = drive_.graph.keyframes()[2].get();
  p.earlier = drive_.graph.keyframes()[1].get();
  const auto motion = entityPrefilters().make("motion", prefilter_);
  // Displaced, but within what the motion model takes for noise.
  EXPECT_TRUE(removed(motion->filter(drive_.graph, p, p.predicted)).empty());
  drive_.graph.tracks().at({1}).back()->moved = true;
  EXPECT_EQ(removed(motion->filter(drive_.graph, p, p.predicted)), (Ids{1}));
}

TEST(EntityPrefilters, UnknownOnesAreAnError) {
  EXPECT_THROW(entityPrefilters().make("sometimes", PrefilterParams{}), ConfigError);
}

}  // namespace
}  // namespace dynemo
