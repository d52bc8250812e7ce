#include "dynemo/life/keyframe_retention.h"

#include <gtest/gtest.h>

#include <set>

#include "dynemo/backend/optimizer.h"
#include "dynemo/life/removal.h"
#include "dynemo/query/scene_query.h"
#include "generated_graph.h"

namespace dynemo {
namespace {

constexpr int kLap = 64;

LifeParams bounded() {
  LifeParams params;
  params.bounded = true;
  params.window = 30;
  params.batch = 1;
  return params;
}

test::WorldParams oneFloor() { return {.keyframes_per_lap = kLap, .storeys = 1}; }

/// Every so often, as a run does it.
void shrink(CSceneGraph& graph, const LifeParams& params) {
  for (const NodeId id : surplusKeyframes(graph, params)) graph.apply(removalOf(graph, id, params));
}

CSceneGraph drive(int keyframes, const LifeParams& params) {
  test::GeneratedWorld world(oneFloor());
  CSceneGraph graph;
  Optimizer optimizer{SolverParams()};
  for (int k = 0; k < keyframes; ++k) {
    graph.apply(world.nextKeyframe(graph));
    shrink(graph, params);
    optimizer.optimize(graph);
  }
  return graph;
}

TEST(KeyframeRetention, AFirstLapStays) {
  LifeParams params = bounded();
  params.cell_m = 0.5;
  EXPECT_TRUE(surplusKeyframes(test::generateGraph(oneFloor(), kLap), params).empty());
}

TEST(KeyframeRetention, LapsOverTheSameFloorAddNothing) {
  const LifeParams params = bounded();
  const CSceneGraph few = drive(4 * kLap, params), many = drive(10 * kLap, params);
  EXPECT_LT(many.keyframes().size(), 1.25 * static_cast<double>(few.keyframes().size()));
  EXPECT_LT(many.edgeCount(), 1.4 * static_cast<double>(few.edgeCount()));
  EXPECT_LT(many.keyframes().size(), 4u * kLap);
}

TEST(KeyframeRetention, TheNewestStay) {
  const CSceneGraph graph = test::generateGraph(oneFloor(), 5 * kLap);
  const LifeParams params = bounded();
  const auto surplus = surplusKeyframes(graph, params);
  ASSERT_GT(surplus.size(), 50u);
  EXPECT_LT(surplus.back(), graph.keyframes()[5 * kLap - 30]->id);
}

TEST(KeyframeRetention, OfEqualOnesTheOldestStay) {
  const CSceneGraph graph = test::generateGraph(oneFloor(), 5 * kLap);
  LifeParams params = bounded();
  params.per_cell = 1000;
  EXPECT_TRUE(surplusKeyframes(graph, params).empty());
  params.per_cell = 2;
  const auto surplus = surplusKeyframes(graph, params);
  std::size_t of_first_lap = 0, of_fourth = 0;
  for (const NodeId id : surplus) {
    const auto k = graph.getNode<CNodeKeyframe>(id).frame_index;
    of_first_lap += k < kLap ? 1 : 0;
    of_fourth += k >= 3 * kLap ? 1 : 0;
  }
  EXPECT_LT(of_first_lap, of_fourth / 2);
}

TEST(KeyframeRetention, TheyLeaveInBatches) {
  const CSceneGraph graph = test::generateGraph(oneFloor(), 5 * kLap);
  LifeParams params = bounded();
  const std::size_t all = surplusKeyframes(graph, params).size();
  params.batch = static_cast<int>(all);
  EXPECT_EQ(surplusKeyframes(graph, params).size(), all);
  params.batch = static_cast<int>(all) + 1;
  EXPECT_TRUE(surplusKeyframes(graph, params).empty());
}

TEST(KeyframeRetention, TheAnchorAndTheFirstOfEachFloorStay) {
  test::WorldParams world;
  world.keyframes_per_lap = 16;
  world.laps_per_floor = 4;
  CSceneGraph graph = test::generateGraph(world, 8 * 16);
  // The generator leaves the keyframes' floors open.
  for (const auto& keyframe : graph.keyframes())
    keyframe->floor = graph.floors()[keyframe->frame_index / 64]->id;
  LifeParams params = bounded();
  params.cell_m = 1000.0;
  params.headings = 1;
  params.per_cell = 1;
  const auto surplus = surplusKeyframes(graph, params);
  const std::set<NodeId> gone(surplus.begin(), surplus.end());
  EXPECT_FALSE(gone.empty());
  EXPECT_FALSE(gone.contains(graph.keyframes()[0]->id));
  EXPECT_FALSE(gone.contains(graph.keyframes()[64]->id));
}

/// A drive in which one object is moved twice.
class MovedObject : public testing::Test {
 protected:
  void SetUp() override {
    full_ = test::generateGraph(oneFloor(), 8 * kLap);
    ASSERT_TRUE(Optimizer(SolverParams()).optimizeFully(full_).usable());
    const auto track = full_.tracks().find(kObject);
    ASSERT_NE(track, full_.tracks().end());
    ASSERT_GT(track->second.size(), 12u);
    const auto displace = [&](std::size_t from, const Pose3& T_map_entity) {
      track->second[from]->moved = true;
      for (std::size_t i = from; i < track->second.size(); ++i)
        track->second[i]->T_map_node = T_map_entity;
    };
    displace(0, Pose3::translation(12, 0, 0.3));
    track->second[0]->moved = false;
    displace(track->second.size() / 3, Pose3::translation(10, 2, 0.3));
    displace(2 * track->second.size() / 3, Pose3::translation(8, 4, 0.3));
  }
  const EntityId kObject{5};
  CSceneGraph full_;
};

TEST_F(MovedObject, QueriesAboutThePastAreAnsweredAsBefore) {
  const std::map<NodeId, Matrix6> no_covariances;
  const QueryParams params;
  const SceneQuery before(full_, no_covariances, params);
  const auto moves = before.movesOf(kObject);
  ASSERT_EQ(moves.size(), 2u);
  std::vector<Pose3> places;
  const auto stampAt = [](int k) { return Stamp{1'000'000'000LL * k}; };
  for (int k = 0; k < 8 * kLap; k += 7)
    places.push_back(before.where(kObject, stampAt(k)).T_map_entity);

  // A copy would do, but nodes are shared: what is asked for is kept above.
  const std::size_t observations = full_.tracks().at(kObject).size();
  shrink(full_, bounded());
  ASSERT_LT(full_.tracks().at(kObject).size(), observations / 2) << "most must leave";
  const SceneQuery after(full_, no_covariances, params);
  const auto same = after.movesOf(kObject);
  ASSERT_EQ(same.size(), moves.size());
  for (std::size_t i = 0; i < moves.size(); ++i) {
    EXPECT_EQ(same[i].last_before, moves[i].last_before);
    EXPECT_EQ(same[i].first_after, moves[i].first_after);
    EXPECT_LT(local(same[i].T_map_after, moves[i].T_map_after).norm(), 1e-12);
  }
  for (int k = 0; k < 8 * kLap; k += 7) {
    const Pose3 T = after.where(kObject, stampAt(k)).T_map_entity;
    EXPECT_LT(local(T, places[static_cast<std::size_t>(k / 7)]).norm(), 1e-12) << k;
  }
}

TEST_F(MovedObject, EveryEntityIsStillKnownFromItsFirstToItsLastObservation) {
  std::map<EntityId, std::pair<Stamp, Stamp>> seen;
  for (const auto& [id, track] : full_.tracks())
    seen[id] = {track.front()->stamp, track.back()->stamp};
  shrink(full_, bounded());
  ASSERT_EQ(full_.tracks().size(), seen.size());
  for (const auto& [id, track] : full_.tracks()) {
    EXPECT_EQ(track.front()->stamp, seen[id].first);
    EXPECT_EQ(track.back()->stamp, seen[id].second);
  }
}

}  // namespace
}  // namespace dynemo
