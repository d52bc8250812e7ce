#include "dynemo/mapping/delta_builder.h"

#include <gtest/gtest.h>

#include <set>

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

template <class Edge>
std::vector<const Edge*> edgesOf(const GraphDelta& delta) {
  std::vector<const Edge*> list;
  for (const auto& edge : delta.edges) {
    if (const auto* e = dynamic_cast<const Edge*>(edge.get())) list.push_back(e);
  }
  return list;
}

class Builder : public testing::Test {
 protected:
  Builder() {
    EntityModel box;
    box.id = {1};
    box.name = "box 1";
    box.origin_height_m = 0.25;
    EntityModel chair;
    chair.id = {2};
    chair.name = "chair 2";
    models_ = EntityModels({box, chair});
  }
  EntityObservation see(int id, const Pose3& T_base_entity) {
    EntityObservation o;
    o.entity = {id};
    o.stamp = Stamp::fromSeconds(t_s_);
    o.T_base_entity = T_base_entity;
    o.covariance = isotropicCovariance(0.02, 0.03);
    return o;
  }
  static PlaneObservation face(const Vector3& center_base, const Vector3& normal_base) {
    PlaneObservation plane;
    plane.patch_base.center = center_base;
    plane.patch_base.normal = normal_base.normalized();
    for (std::int16_t i = -4; i < 4; ++i)
      for (std::int16_t j = -4; j < 4; ++j) plane.patch_base.cells.push_back({i, j});
    plane.covariance = Vector3(1e-6, 1e-6, 4e-6).asDiagonal();
    return plane;
  }
  static void seeGround(KeyframeData& data, double level_m) {
    const double height_m = level_m - data.T_map_base.t.z();
    data.ground = GroundPlane{data.planes.size(), Vector3::UnitZ(), height_m};
    data.planes.push_back(face({1, 0, height_m}, Vector3::UnitZ()));
  }
  /// Builds a keyframe from the observations and adds it to the graph.
  GraphDelta add(const Pose3& T_map_base, std::vector<EntityObservation> observations,
                 std::optional<double> ground_level_m = std::nullopt) {
    KeyframeData data;
    data.stamp = Stamp::fromSeconds(t_s_);
    data.T_odom_base = data.T_map_base = T_map_base;
    data.odometry_covariance = isotropicCovariance(0.02, 0.01);
    if (ground_level_m) seeGround(data, *ground_level_m);
    data.observations = std::move(observations);
    data.fragments.resize(data.observations.size());
    GraphDelta delta = DeltaBuilder(params_, models_).build(graph_, data);
    graph_.apply(delta);
    t_s_ += 1.0;
    return delta;
  }

  MappingParams params_;
  EntityModels models_;
  CSceneGraph graph_;
  double t_s_ = 0.0;
};

TEST_F(Builder, TheFirstKeyframeIsAnchoredAndLaterOnesChained) {
  const GraphDelta first = add(Pose3(), {});
  EXPECT_EQ(edgesOf<CEdgePosePrior>(first).size(), 1u);
  EXPECT_TRUE(edgesOf<CEdgeOdometry>(first).empty());
  const GraphDelta second = add(Pose3::translation(1, 0, 0), {});
  ASSERT_EQ(edgesOf<CEdgeOdometry>(second).size(), 1u);
  EXPECT_NEAR(edgesOf<CEdgeOdometry>(second)[0]->T_1_2.t.x(), 1.0, 1e-12);
  EXPECT_TRUE(edgesOf<CEdgePosePrior>(second).empty());
}

TEST_F(Builder, OneNodePerEntityAndKeyframeWithOneEdgePerSensor) {
  auto left = see(1, Pose3::translation(2, 0, 0)), right = left;
  left.sensor_label = "left";
  right.sensor_label = "right";
  right.covariance *= 0.25;
  right.T_base_entity.t.x() = 2.02;
  const GraphDelta delta = add(Pose3(), {left, right, see(2, Pose3::translation(3, 1, 0))});
  EXPECT_EQ(graph_.tracks().size(), 2u);
  EXPECT_EQ(edgesOf<CEdgeKeyframeEntity>(delta).size(), 3u);
  EXPECT_NEAR(graph_.lastObservation({1})->T_map_entity().t.x(), 2.02, 1e-12)
      << "the best sensor initialises";
}

TEST_F(Builder, BuildingIsPure) {
  add(Pose3(), {see(1, Pose3::translation(2, 0, 0))}, -0.1);
  const std::size_t nodes = graph_.nodeCount(), edges = graph_.edgeCount();
  KeyframeData data;
  data.T_map_base = data.T_odom_base = Pose3::translation(1, 0, 0);
  data.observations = {see(1, Pose3::translation(1, 0, 0))};
  const DeltaBuilder builder(params_, models_);
  const GraphDelta a = builder.build(graph_, data), b = builder.build(graph_, data);
  EXPECT_EQ(graph_.nodeCount(), nodes);
  EXPECT_EQ(graph_.edgeCount(), edges);
  ASSERT_EQ(a.edges.size(), b.edges.size());
  EXPECT_EQ(a.nodes.front()->id, b.nodes.front()->id);
}

TEST_F(Builder, SwitchesLeaveTheirConstraintsOut) {
  params_.intra_entity = false;
  params_.floor_entity = false;
  add(Pose3(), {see(1, Pose3::translation(2, 0, 0))}, -0.1);
  const GraphDelta delta = add(Pose3::translation(1, 0, 0), {see(1, Pose3::translation(1, 0, 0))});
  EXPECT_TRUE(edgesOf<CEdgeIntraEntity>(delta).empty());
  EXPECT_TRUE(edgesOf<CEdgeFloorEntity>(delta).empty());
  EXPECT_EQ(edgesOf<CEdgeKeyframeEntity>(delta).size(), 1u);
  params_.keyframe_entity = false;
  const GraphDelta bare = add(Pose3::translation(2, 0, 0), {see(1, Pose3::translation(0, 0, 0))});
  EXPECT_EQ(bare.nodes.size(), 1u);
}

TEST_F(Builder, MovedFlagIsSetEvenWithoutIntraEntityEdges) {
  params_.intra_entity = false;
  add(Pose3(), {see(1, Pose3::translation(2, 0, 0))});
  add(Pose3(), {see(1, Pose3::translation(4, 0, 0))});
  EXPECT_TRUE(graph_.lastObservation({1})->moved);
}

TEST_F(Builder, KnownHeightIsUsedWhenTheEntityStandsOnTheFloor) {
  const GraphDelta delta = add(Pose3(), {see(1, Pose3::translation(2, 0, 0.2))}, -0.1);
  ASSERT_EQ(edgesOf<CEdgeFloorEntity>(delta).size(), 1u);
  EXPECT_NEAR(edgesOf<CEdgeFloorEntity>(delta)[0]->offset_m, -0.25, 1e-12);
}

TEST_F(Builder, AnEntityOnATableKeepsItsFirstSeenHeight) {
  const GraphDelta first = add(Pose3(), {see(1, Pose3::translation(2, 0, 0.9))}, -0.1);
  EXPECT_NEAR(edgesOf<CEdgeFloorEntity>(first)[0]->offset_m, -1.0, 1e-12);
  const GraphDelta second = add(Pose3(), {see(1, Pose3::translation(2, 0, 0.95))});
  EXPECT_NEAR(edgesOf<CEdgeFloorEntity>(second)[0]->offset_m, -1.0, 1e-12);
}

TEST_F(Builder, AConfirmedChangeOfHeightStartsAnew) {
  add(Pose3(), {see(2, Pose3::translation(2, 0, 0.4))}, 0.0);
  const GraphDelta delta = add(Pose3(), {see(2, Pose3::translation(2, 0, 1.2))});
  EXPECT_NEAR(edgesOf<CEdgeFloorEntity>(delta)[0]->offset_m, -1.2, 1e-12);
}

TEST_F(Builder, WithoutLidarAnEntityOfKnownHeightGivesTheFloor) {
  add(Pose3(), {see(2, Pose3::translation(2, 0, 0.4))});
  EXPECT_TRUE(graph_.floors().empty());
  add(Pose3(), {see(1, Pose3::translation(2, 0, 0.15))});
  ASSERT_EQ(graph_.floors().size(), 1u);
  EXPECT_NEAR(graph_.floors()[0]->level_m, -0.10, 1e-12);
}

TEST_F(Builder, TheGroundTiesEveryKeyframeToItsFloor) {
  const GraphDelta first = add(Pose3::translation(0, 0, 0.1), {}, -0.1);
  ASSERT_EQ(edgesOf<CEdgeFloorGround>(first).size(), 1u);
  EXPECT_TRUE(edgesOf<CEdgeFloorPrior>(first).empty()) << "the ground is the gauge";
  EXPECT_NEAR(graph_.floors()[0]->level_m, -0.1, 1e-12);
  EXPECT_NEAR(graph_.edgeCost(*edgesOf<CEdgeFloorGround>(first)[0]), 0.0, 1e-12);
  const GraphDelta second = add(Pose3::translation(1, 0, 0.15), {}, -0.05);
  ASSERT_EQ(edgesOf<CEdgeFloorGround>(second).size(), 1u);
  EXPECT_EQ(graph_.floors().size(), 1u);
  EXPECT_GT(graph_.edgeCost(*edgesOf<CEdgeFloorGround>(second)[0]), 1.0);
}

class PlaneBuilder : public Builder {
 protected:
  GraphDelta addPlanes(const Pose3& T_map_base, std::vector<PlaneObservation> planes,
                       PlaneAssociation association = {}) {
    KeyframeData data;
    data.stamp = Stamp::fromSeconds(t_s_);
    data.T_odom_base = data.T_map_base = T_map_base;
    data.odometry_covariance = isotropicCovariance(0.02, 0.01);
    data.planes = std::move(planes);
    data.plane_association = std::move(association);
    GraphDelta delta = DeltaBuilder(params_, models_).build(graph_, data);
    graph_.apply(delta);
    t_s_ += 1.0;
    return delta;
  }
};

TEST_F(PlaneBuilder, WallsAndCeilingsBecomeNodesAndTablesDoNot) {
  const Pose3 T_map_base = Pose3::fromYawPitchRoll(2, 1, 0, 0.6, 0, 0);
  const GraphDelta delta =
      addPlanes(T_map_base, {face({3, 0, 1}, -Vector3::UnitX()), face({0, 0, 2}, -Vector3::UnitZ()),
                             face({1, 1, 0.7}, Vector3::UnitZ())});
  ASSERT_EQ(graph_.planes().size(), 2u);
  ASSERT_EQ(edgesOf<CEdgeKeyframePlane>(delta).size(), 2u);
  for (const auto* edge : edgesOf<CEdgeKeyframePlane>(delta)) {
    EXPECT_NEAR(graph_.edgeCost(*edge), 0.0, 1e-12);
  }
  EXPECT_NEAR(graph_.planes()[0]->plane_map.distance(T_map_base * Vector3(3, 0.5, 0)), 0, 1e-12);
}

TEST_F(PlaneBuilder, AnUncertainPlaneIsNotMapped) {
  PlaneObservation sliver = face({3, 0, 1}, -Vector3::UnitX());
  sliver.covariance(0, 0) = 0.01;
  addPlanes(Pose3(), {sliver});
  EXPECT_TRUE(graph_.planes().empty());
}

TEST_F(PlaneBuilder, AnAssociatedPlaneGetsAnEdgeAndNoNode) {
  addPlanes(Pose3(), {face({3, 0, 1}, -Vector3::UnitX())});
  const NodeId wall = graph_.planes()[0]->id;
  const GraphDelta delta =
      addPlanes(Pose3::translation(1, 0, 0), {face({2, 0, 1}, -Vector3::UnitX())}, {{wall}, {}});
  EXPECT_EQ(graph_.planes().size(), 1u);
  ASSERT_EQ(edgesOf<CEdgeKeyframePlane>(delta).size(), 1u);
  EXPECT_EQ(edgesOf<CEdgeKeyframePlane>(delta)[0]->nodes[1], wall);
}

TEST_F(PlaneBuilder, MergingRehangsTheEdgesAndTakesTheDuplicateOut) {
  addPlanes(Pose3(), {face({3, -2, 1}, -Vector3::UnitX())});
  addPlanes(Pose3::translation(1, 0, 0), {face({2, 2, 1}, -Vector3::UnitX())});
  ASSERT_EQ(graph_.planes().size(), 2u);
  const NodeId kept = graph_.planes()[0]->id, removed = graph_.planes()[1]->id;
  const std::size_t edges = graph_.edgeCount();
  const double cost = graph_.totalCost();
  addPlanes(Pose3::translation(2, 0, 0), {face({1, 0, 1}, -Vector3::UnitX())},
            {{kept}, {{kept, removed}}});
  ASSERT_EQ(graph_.planes().size(), 1u);
  EXPECT_EQ(graph_.findNode<CNodePlane>(removed), nullptr);
  EXPECT_EQ(graph_.edgesOf(kept).size(), 3u);
  EXPECT_EQ(graph_.edgeCount(), edges + 2) << "odometry and the observation";
  EXPECT_NEAR(graph_.totalCost(), cost, 1e-12);
}

TEST_F(PlaneBuilder, RegularWallsAreTiedWhenAsked) {
  const auto walls = {face({3, 0, 1}, -Vector3::UnitX()), face({0, 3, 1}, Vector3(0.01, -1, 0)),
                      face({-3, 0, 1}, Vector3(1, 0.005, 0)), face({3, 3, 1}, Vector3(-1, -1, 0))};
  EXPECT_TRUE(edgesOf<CEdgePlanePerpendicular>(addPlanes(Pose3(), walls)).empty());
  params_.planes.regular_walls = true;
  graph_ = CSceneGraph();
  KeyframeData first;
  first.planes = {*walls.begin()};
  seeGround(first, -0.1);
  graph_.apply(DeltaBuilder(params_, models_).build(graph_, first));
  const GraphDelta delta = addPlanes(Pose3(), {walls.begin() + 1, walls.end()});
  EXPECT_EQ(edgesOf<CEdgePlanePerpendicular>(delta).size(), 1u);
  EXPECT_EQ(edgesOf<CEdgePlaneParallel>(delta).size(), 1u);
}

TEST_F(Builder, RelativePoseCovarianceMatchesSampling) {
  const Pose3 T_1 = Pose3::fromYawPitchRoll(1, 2, 3, 0.4, 0.1, -0.2),
              T_2 = Pose3::fromYawPitchRoll(-1, 0.5, 2, 1.4, 0, 0);
  std::mt19937_64 rng(5);
  const MatrixX joint = 1e-6 * randomInformation(12, rng);
  const Matrix6 cov = relativePoseCovariance(T_1, T_2, joint);
  // Numerically: push basis perturbations through.
  Eigen::Matrix<double, 6, 12> J;
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 12; ++i) {
    Vector6 d = Vector6::Zero();
    d[i % 6] = kStep;
    const Pose3 A = i < 6 ? T_1.retract(d) : T_1, B = i < 6 ? T_2 : T_2.retract(d);
    J.col(i) = local(T_1.inverse() * T_2, A.inverse() * B) / kStep;
  }
  EXPECT_LT((J * joint * J.transpose() - cov).norm() / cov.norm(), 1e-4);
}

}  // namespace
}  // namespace dynemo
