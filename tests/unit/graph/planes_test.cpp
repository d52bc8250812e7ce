// Planes in the graph: where they were seen, and nodes that leave it.
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/seen_plane.h"
#include "dynemo/graph/types.h"

namespace dynemo::test {
namespace {

/// Keyframes 0 and 1, walls 2 and 3, a floor 4. Wall 2 is seen from both, wall 3 from keyframe 1.
class PlaneGraph : public ::testing::Test {
 protected:
  PlaneGraph() {
    registerGraphClasses();
    GraphDelta delta;
    auto k0 = std::make_shared<CNodeKeyframe>(), k1 = std::make_shared<CNodeKeyframe>();
    k1->T_map_node = Pose3::fromYawPitchRoll(1, 0, 0, 0.5, 0, 0);
    auto w2 = std::make_shared<CNodePlane>(), w3 = std::make_shared<CNodePlane>();
    w2->plane_map = {-Vector3::UnitX(), 3.0};
    w3->plane_map = {-Vector3::UnitY(), 2.0};
    delta.nodes = {k0, k1, w2, w3, std::make_shared<CNodeFloor>()};
    for (std::size_t i = 0; i < delta.nodes.size(); ++i) delta.nodes[i]->id = {i};
    delta.edges = {seen(0, *k0, *w2, {3, -2, 0}), seen(1, *k1, *w2, {3, 2, 0}),
                   seen(2, *k1, *w3, {0, 2, 1})};
    graph_.apply(delta);
  }

  /// Two by two metres around the center.
  static CEdgeBase::Ptr seen(std::uint64_t id, const CNodeKeyframe& keyframe,
                             const CNodePlane& plane, const Vector3& center_map) {
    auto edge = std::make_shared<CEdgeKeyframePlane>();
    edge->id = {id};
    edge->nodes = {keyframe.id, plane.id};
    edge->patch_base.center = keyframe.T_map_base().inverse() * center_map;
    edge->patch_base.normal = keyframe.T_map_base().R.transpose() * plane.plane_map.normal;
    for (std::int16_t i = -4; i < 4; ++i)
      for (std::int16_t j = -4; j < 4; ++j) edge->patch_base.cells.push_back({i, j});
    edge->setInformation(Matrix3::Identity());
    return edge;
  }

  CSceneGraph graph_;
};

TEST_F(PlaneGraph, WhatTheEdgesMeasureIsThePlane) {
  for (const auto& edge : graph_.edgeSlots()) EXPECT_NEAR(graph_.edgeCost(*edge), 0.0, 1e-20);
}

TEST_F(PlaneGraph, ThePatchIsTheUnionOfWhatWasSeen) {
  const PlanePatch patch = seenPatch(graph_, *graph_.planes()[0]);
  // Two squares of 2 m; cells that are cut count in full.
  EXPECT_GT(patch.area_m2(), 7.9);
  EXPECT_LT(patch.area_m2(), 12.0);
  EXPECT_LT((middleOf(patch) - Vector3(3, 0, 0)).norm(), 0.15);
  for (const Vector3& p : cellCenters(patch)) {
    EXPECT_NEAR(p.x(), 3.0, 1e-9);
    EXPECT_GT(std::abs(p.y()), 0.7);
    EXPECT_LT(std::abs(p.y()), 3.4);
  }
}

TEST_F(PlaneGraph, GapsAreMeasuredBetweenPatches) {
  const auto a = cellCenters(seenPatch(graph_, *graph_.planes()[0]));
  const auto b = cellCenters(seenPatch(graph_, *graph_.planes()[1]));
  EXPECT_TRUE(withinGap(a, b, 2.5));
  EXPECT_FALSE(withinGap(a, b, 1.0));
  EXPECT_FALSE(withinGap(a, {}, 100.0));
}

TEST_F(PlaneGraph, ANodeLeavesWithItsEdges) {
  GraphDelta removal;
  removal.removed_nodes = {NodeId{3}};
  EXPECT_THROW(graph_.apply(removal), std::logic_error) << "an edge still hangs on it";
  removal.removed_edges = {EdgeId{2}};
  graph_.apply(removal);
  EXPECT_EQ(graph_.nodeCount(), 4u);
  EXPECT_EQ(graph_.planes().size(), 1u);
  EXPECT_EQ(graph_.findNode<CNodePlane>({3}), nullptr);
  EXPECT_EQ(graph_.nextNodeId(), NodeId{5}) << "ids are not used again";
  removal.removed_edges.clear();
  EXPECT_THROW(graph_.apply(removal), std::logic_error) << "twice";
}

TEST_F(PlaneGraph, AGraphWithRemovedNodesIsStoredAndReadBack) {
  GraphDelta removal;
  removal.removed_nodes = {NodeId{3}};
  removal.removed_edges = {EdgeId{2}};
  removal.floor_areas = {{NodeId{4}, {Vector2(-1, 0), Vector2(3, 2)}}};
  graph_.apply(removal);
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << graph_;
  stream.Seek(0);
  CSceneGraph copy;
  archive >> copy;
  EXPECT_EQ(copy.nextNodeId(), NodeId{5});
  EXPECT_EQ(copy.nodeSlots()[3], nullptr);
  ASSERT_EQ(copy.planes().size(), 1u);
  EXPECT_EQ(copy.planes()[0]->plane_map.d_m, 3.0);
  EXPECT_EQ(seenPatch(copy, *copy.planes()[0]).cells, seenPatch(graph_, *graph_.planes()[0]).cells);
  EXPECT_EQ(copy.floors()[0]->center_map_m, Vector2(1, 1));
  EXPECT_EQ(copy.floors()[0]->area_map_m.max(), Vector2(3, 2));
  EXPECT_EQ(copy.totalCost(), graph_.totalCost());
}

TEST_F(PlaneGraph, OnlyFloorsHaveAreas) {
  GraphDelta delta;
  delta.floor_areas = {{NodeId{2}, {Vector2(-1, 0), Vector2(3, 2)}}};
  EXPECT_THROW(graph_.apply(delta), std::logic_error);
}

TEST(Planes, MoveWithTheirFrame) {
  const Pose3 T = Pose3::fromYawPitchRoll(1, -2, 0.5, 0.7, 0.2, -0.4);
  const Plane3 plane = Plane3::through({1, 2, 3}, Vector3(1, -2, 0.5).normalized());
  EXPECT_NEAR((T * plane).distance(T * Vector3(1, 2, 3)), 0.0, 1e-12);
  EXPECT_NEAR((T * plane).distance(T * (Vector3(1, 2, 3) + 0.7 * plane.normal)), 0.7, 1e-12);
}

TEST(Planes, LogAndExpOfTheSphereAreInverse) {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 200; ++i) {
    const Vector3 u = randomPose(rng).R.col(0), v = randomPose(rng).R.col(1);
    EXPECT_LT((sphereExp(u, sphereLog(u, v).w) - v).norm(), 1e-9);
    const Vector2 small(1e-9 * (i % 7), -2e-9);
    EXPECT_LT((sphereLog(u, sphereExp(u, small)).w - small).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace dynemo::test
