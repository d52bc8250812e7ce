#include "dynemo/mapping/plane_association.h"

#include <gtest/gtest.h>

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_plane.h"

namespace dynemo {
namespace {

constexpr double kSigma_m = 0.004, kSigma_rad = 0.003;

/// A graph with one keyframe at the origin and walls seen from it; predictions from a made-up
/// covariance.
class Association : public ::testing::Test {
 protected:
  Association() { keyframe_ = add(std::make_shared<CNodeKeyframe>()); }

  /// A face of 4 × 2 m around the center.
  static PlaneObservation face(const Vector3& center, const Vector3& normal) {
    PlaneObservation o;
    o.patch_base.center = center;
    o.patch_base.normal = normal.normalized();
    for (std::int16_t i = -8; i < 8; ++i)
      for (std::int16_t j = -8; j < 8; ++j) o.patch_base.cells.push_back({i, j});
    o.covariance = Vector3(kSigma_rad, kSigma_rad, kSigma_m).array().square().matrix().asDiagonal();
    return o;
  }

  NodeId map(const PlaneObservation& seen) {
    auto node = std::make_shared<CNodePlane>();
    node->plane_map = seen.patch_base.plane();
    const NodeId id = add(node);
    auto edge = std::make_shared<CEdgeKeyframePlane>();
    edge->id = graph_.nextEdgeId();
    edge->nodes = {keyframe_, id};
    edge->patch_base = seen.patch_base;
    edge->setCovariance(seen.covariance);
    GraphDelta delta;
    delta.edges = {edge};
    graph_.apply(delta);
    return id;
  }

  /// All planes and the robot independent, with the given uncertainties.
  PlaneAssociation associate(const std::vector<PlaneObservation>& seen, const Pose3& T_map_base,
                             double robot_sigma_m = 0.01, double plane_sigma_m = 0.005) {
    const auto candidates = planeCandidates(graph_, T_map_base, seen, params_);
    const auto n = static_cast<Eigen::Index>(6 + 3 * candidates.size());
    MatrixX joint = MatrixX::Zero(n, n);
    joint.topLeftCorner(6, 6) = isotropicCovariance(robot_sigma_m, 0.002);
    for (Eigen::Index i = 6; i < n; i += 3) {
      joint.diagonal().segment<3>(i) << 1e-6, 1e-6, plane_sigma_m * plane_sigma_m;
    }
    const KeyframePrediction prediction(graph_, T_map_base, 1e-8 * Matrix6::Identity(), candidates,
                                        joint);
    return associatePlanes(graph_, prediction, seen, params_);
  }

  NodeId add(const CNodeBase::Ptr& node) {
    node->id = graph_.nextNodeId();
    GraphDelta delta;
    delta.nodes = {node};
    graph_.apply(delta);
    return node->id;
  }

  CSceneGraph graph_;
  NodeId keyframe_{};
  PlaneAssociationParams params_;
};

TEST_F(Association, AWallIsFoundAgainFromElsewhere) {
  const NodeId wall = map(face({3, 0, 1}, {-1, 0, 0}));
  map(face({0, 4, 1}, {0, -1, 0}));
  const Pose3 T_map_base = Pose3::fromYawPitchRoll(1, 0.5, 0, 0.4, 0, 0);
  PlaneObservation seen = face(T_map_base.inverse() * Vector3(3.01, 0.4, 1),
                               T_map_base.R.transpose() * Vector3(-1, 0, 0));
  const auto result = associate({seen}, T_map_base);
  ASSERT_EQ(result.plane.size(), 1u);
  EXPECT_EQ(result.plane[0], wall);
  EXPECT_TRUE(result.merges.empty());
}

TEST_F(Association, TheFacesOfAThinWallStayTwo) {
  const NodeId front = map(face({3, 0, 1}, {-1, 0, 0}));
  const NodeId back = map(face({3.12, 0, 1}, {1, 0, 0}));
  const auto result =
      associate({face({3.0, 0, 1}, {-1, 0, 0}), face({3.12, 0, 1}, {1, 0, 0})}, Pose3(), 0.2);
  EXPECT_EQ(result.plane[0], front);
  EXPECT_EQ(result.plane[1], back);
  EXPECT_TRUE(result.merges.empty());
}

TEST_F(Association, UncertaintyDecidesWhatIsTheSame) {
  const NodeId wall = map(face({3, 0, 1}, {-1, 0, 0}));
  const auto shifted = face({3.2, 0, 1}, {-1, 0, 0});
  EXPECT_FALSE(associate({shifted}, Pose3(), 0.01).plane[0]);
  EXPECT_EQ(associate({shifted}, Pose3(), 0.10).plane[0], wall);
  EXPECT_FALSE(associate({face({3.8, 0, 1}, {-1, 0, 0})}, Pose3(), 1.0).plane[0])
      << "however uncertain the robot is";
}

TEST_F(Association, AFaceThatWouldHideAMappedOneIsThatOne) {
  const NodeId wall = map(face({3, 0, 1}, {-1, 0, 0}));
  // Beyond the uncertainty, but a wall cannot be seen through another.
  const auto slipped = associate({face({2.92, 0.3, 1}, {-1, 0, 0})}, Pose3(), 0.01);
  EXPECT_EQ(slipped.plane[0], wall);
  Matrix6 slip = Matrix6::Zero();
  slip(0, 0) = 0.08 * 0.08;
  EXPECT_TRUE(slipped.slip.isApprox(slip, 1e-9)) << slipped.slip;
  EXPECT_TRUE(associate({face({3.0, 0.3, 1}, {-1, 0, 0})}, Pose3(), 0.01).slip.isZero());

  const auto beside = associate({face({2.92, 3.0, 1}, {-1, 0, 0})}, Pose3(), 0.01);
  EXPECT_FALSE(beside.plane[0]) << "a quarter of it alone is in front of the wall";
  EXPECT_TRUE(beside.slip.isZero());
  const auto other_side = associate({face({2.92, 0, 1}, {1, 0, 0})}, Pose3(), 0.01);
  EXPECT_FALSE(other_side.plane[0]) << "the back of a thin wall";
  params_.max_slip_m = 0.05;
  EXPECT_FALSE(associate({face({2.92, 0.3, 1}, {-1, 0, 0})}, Pose3(), 0.01).plane[0]);
}

TEST_F(Association, OfSeveralTheNearestIsTaken) {
  const NodeId near = map(face({3.0, 0, 1}, {-1, 0, 0}));
  const NodeId far = map(face({3.2, 0, 1}, {-1, 0, 0}));
  EXPECT_EQ(associate({face({3.04, 0, 1}, {-1, 0, 0})}, Pose3(), 0.1).plane[0], near);
  EXPECT_EQ(associate({face({3.17, 0, 1}, {-1, 0, 0})}, Pose3(), 0.1).plane[0], far);
}

TEST_F(Association, WallsOfOneLineFarApartAreDifferent) {
  map(face({3, 0, 1}, {-1, 0, 0}));
  params_.max_gap_m = 2.0;
  EXPECT_FALSE(associate({face({3, 12, 1}, {-1, 0, 0})}, Pose3()).plane[0]);
  EXPECT_TRUE(associate({face({3, 5, 1}, {-1, 0, 0})}, Pose3()).plane[0]);
}

TEST_F(Association, DuplicatesAreMergedIntoTheOldest) {
  const NodeId oldest = map(face({3.00, -2, 1}, {-1, 0, 0}));
  const NodeId other = map(face({3.004, 2, 1}, {-1, 0, 0}));
  const NodeId third = map(face({2.998, 3, 1}, {-1, 0, 0}));
  const auto result = associate({face({3.0, 0, 1}, {-1, 0, 0})}, Pose3());
  ASSERT_EQ(result.merges.size(), 2u);
  for (const PlaneMerge& merge : result.merges) EXPECT_EQ(merge.kept, oldest);
  EXPECT_EQ(std::min(result.merges[0].removed, result.merges[1].removed), other);
  EXPECT_EQ(std::max(result.merges[0].removed, result.merges[1].removed), third);
  EXPECT_EQ(result.plane[0], oldest);
}

TEST_F(Association, WhatBothCouldBeIsNotMergedWhenTheTwoDiffer) {
  map(face({3.0, 0, 1}, {-1, 0, 0}));
  map(face({3.1, 0, 1}, {-1, 0, 0}));
  // The robot does not know which of them it sees; the map knows that they are two.
  const auto result = associate({face({3.05, 0, 1}, {-1, 0, 0})}, Pose3(), 0.1, 0.002);
  EXPECT_TRUE(result.plane[0]);
  EXPECT_TRUE(result.merges.empty());
}

}  // namespace
}  // namespace dynemo
