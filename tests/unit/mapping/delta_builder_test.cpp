#include "dynemo/mapping/delta_builder.h"

#include <gtest/gtest.h>

#include <set>

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_floor_entity.h"
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
  /// Builds a keyframe from the observations and adds it to the graph.
  GraphDelta add(const Pose3& T_map_base, std::vector<EntityObservation> observations,
                 std::optional<double> ground_level_m = std::nullopt) {
    KeyframeData data;
    data.stamp = Stamp::fromSeconds(t_s_);
    data.T_odom_base = data.T_map_base = T_map_base;
    data.odometry_covariance = isotropicCovariance(0.02, 0.01);
    data.ground_level_m = ground_level_m;
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
