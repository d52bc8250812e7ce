#include <gtest/gtest.h>

#include "dynemo/core/noise.h"
#include "dynemo/entities/motion_model.h"
#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

constexpr double kTight = 1e-12;

CNodeEntity node(std::uint64_t id, double t_s, const Pose3& T_map_entity) {
  CNodeEntity n;
  n.id = {id};
  n.entity = {7};
  n.stamp = Stamp::fromSeconds(t_s);
  n.T_map_node = T_map_entity;
  return n;
}

class MotionModels : public testing::Test {
 protected:
  MotionConstraint constrain(const std::string& name, const CNodeEntity& current,
                             const EntityModel* model = nullptr) {
    std::vector<const CNodeEntity*> history;
    for (const auto& n : history_) history.push_back(&n);
    const MotionContext context{model, history, current, covariance_};
    return motionModels().make(name, params_)->constrain(context);
  }

  MotionParams params_;
  std::vector<CNodeEntity> history_ = {node(0, 0.0, Pose3::translation(1, 2, 0))};
  Matrix6 covariance_ = isotropicCovariance(0.05, 0.05);
};

TEST_F(MotionModels, RestingObjectIsHeldByTheIdentity) {
  const auto c = constrain("object", node(1, 1.0, Pose3::translation(1.04, 2.03, 0)));
  EXPECT_FALSE(c.moved);
  ASSERT_EQ(c.edges.size(), 1u);
  const auto& edge = dynamic_cast<const CEdgeIntraEntity&>(*c.edges[0]);
  EXPECT_EQ(edge.motion_model, "static_object");
  EXPECT_EQ(edge.nodes, (std::vector<NodeId>{{0}, {1}}));
  EXPECT_LT(local(Pose3(), edge.T_1_2).norm(), kTight);
}

TEST_F(MotionModels, DisplacedObjectIsMovedAndFreeInTheConsistentForm) {
  const auto c = constrain("object", node(1, 1.0, Pose3::translation(2, 2, 0)));
  EXPECT_TRUE(c.moved);
  EXPECT_TRUE(c.edges.empty());
}

TEST_F(MotionModels, DisplacedObjectKeepsItsRelativePoseInThePaperForm) {
  params_.form = MotionForm::kPaper;
  const Pose3 T = Pose3::fromYawPitchRoll(2, 3, 0.1, 0.5, 0, 0);
  const auto c = constrain("object", node(1, 1.0, T));
  EXPECT_TRUE(c.moved);
  ASSERT_EQ(c.edges.size(), 1u);
  const auto& edge = dynamic_cast<const CEdgeIntraEntity&>(*c.edges[0]);
  EXPECT_LT(local(history_[0].T_map_entity().inverse() * T, edge.T_1_2).norm(), kTight);
  EXPECT_NEAR(edge.information()(0, 0), 1.0 / (params_.relative_sigma_m * params_.relative_sigma_m),
              kTight);
}

TEST_F(MotionModels, UncertaintyDecidesWhetherADisplacementIsMotion) {
  const CNodeEntity current = node(1, 1.0, Pose3::translation(1.3, 2, 0));
  EXPECT_TRUE(constrain("object", current).moved);
  covariance_ = isotropicCovariance(0.3, 0.1);  // a robot that has drifted
  EXPECT_FALSE(constrain("object", current).moved);
}

TEST_F(MotionModels, RotationAloneIsMotion) {
  EXPECT_TRUE(constrain("object", node(1, 1.0, Pose3::fromYawPitchRoll(1, 2, 0, 0.8, 0, 0))).moved);
}

TEST_F(MotionModels, SignificantButTinyDisplacementIsNoMotion) {
  covariance_ = isotropicCovariance(0.001, 0.001);
  EXPECT_FALSE(constrain("object", node(1, 1.0, Pose3::translation(1.05, 2, 0))).moved);
}

TEST_F(MotionModels, ASmallUnexplainedDisplacementIsHeldLoosely) {
  EXPECT_EQ(constrain("object", node(1, 1.0, Pose3::translation(1.02, 2, 0))).edges[0]->kernel.type,
            KernelType::kHuber);
  covariance_ = isotropicCovariance(0.003, 0.003);
  EXPECT_EQ(constrain("object", node(1, 1.0, Pose3::translation(1.06, 2, 0))).edges[0]->kernel.type,
            KernelType::kCauchy);
}

TEST_F(MotionModels, ASlowlyPushedObjectIsFoundMoved) {
  covariance_ = isotropicCovariance(0.003, 0.003);
  bool found = false;
  for (int i = 1; i < 6; ++i) {
    CNodeEntity next =
        node(static_cast<std::uint64_t>(i), i, Pose3::translation(1 + 0.04 * i, 2, 0));
    next.moved = constrain("object", next).moved;
    found |= next.moved;
    EXPECT_EQ(next.moved, i == 3) << i;  // 12 cm from where it was put down; then counted anew
    history_.push_back(next);
  }
  EXPECT_TRUE(found);
}

TEST_F(MotionModels, AnUnchainedTrackIsComparedWithItsPreviousObservationOnly) {
  covariance_ = isotropicCovariance(0.003, 0.003);
  history_ = {node(0, 0.0, Pose3::translation(1, 2, 0)),
              node(1, 30.0, Pose3::translation(1.5, 2, 0))};
  std::vector<const CNodeEntity*> history = {&history_[0], &history_[1]};
  const CNodeEntity current = node(2, 31.0, Pose3::translation(1.51, 2, 0));
  const auto model = motionModels().make("object", params_);
  EXPECT_TRUE(model->constrain({nullptr, history, current, covariance_, true}).moved);
  EXPECT_FALSE(model->constrain({nullptr, history, current, covariance_, false}).moved);
}

TEST_F(MotionModels, PaperLineProjectsTheRelativePoseOntoU) {
  params_.form = MotionForm::kPaper;
  EntityModel model;
  model.direction_entity = Vector3::UnitX();
  const auto c = constrain("agent_line",
                           node(1, 1.0, Pose3::fromYawPitchRoll(2, 2.4, 0.1, 0.3, 0, 0)), &model);
  ASSERT_EQ(c.edges.size(), 1u);
  const auto& edge = dynamic_cast<const CEdgeIntraEntity&>(*c.edges[0]);
  EXPECT_LT((edge.T_1_2.t - Vector3(1, 0, 0)).norm(), kTight);
  EXPECT_LT(rotationAngle(edge.T_1_2), kTight);
  EXPECT_NEAR(edge.information()(0, 0),
              1.0 / (params_.line_sigma_along_m * params_.line_sigma_along_m), 1e-9);
  EXPECT_NEAR(edge.information()(1, 1),
              1.0 / (params_.line_sigma_across_m * params_.line_sigma_across_m), 1e-9);
}

TEST_F(MotionModels, PaperLineRotatesTheInformationWithU) {
  params_.form = MotionForm::kPaper;
  EntityModel model;
  model.direction_entity = Vector3(0, 1, 0);
  const auto c = constrain("agent_line", node(1, 1.0, Pose3::translation(1, 3, 0)), &model);
  const auto& information = c.edges.at(0)->information();
  EXPECT_NEAR(information(1, 1), 1.0 / (params_.line_sigma_along_m * params_.line_sigma_along_m),
              1e-9);
  EXPECT_NEAR(information(0, 0), 1.0 / (params_.line_sigma_across_m * params_.line_sigma_across_m),
              1e-9);
}

TEST_F(MotionModels, PaperLineIsFittedFromThreePositions) {
  params_.form = MotionForm::kPaper;
  history_ = {node(0, 0.0, Pose3::fromYawPitchRoll(0, 0, 0, 1.0, 0, 0)),
              node(1, 0.5, Pose3::fromYawPitchRoll(0, 0.5, 0, 1.0, 0, 0))};
  const auto c =
      constrain("agent_line", node(2, 1.0, Pose3::fromYawPitchRoll(0.05, 1.0, 0, 1.0, 0, 0)));
  const auto& edge = dynamic_cast<const CEdgeIntraEntity&>(*c.edges.at(0));
  EXPECT_EQ(edge.motion_model, "agent_line");
  const Vector3 step_map = history_[1].T_map_entity().R * edge.T_1_2.t;
  EXPECT_NEAR(step_map.y(), 0.5, 0.03);
  EXPECT_LT(std::abs(step_map.x()), 0.05);
}

TEST_F(MotionModels, WithoutALineThePaperFormKeepsTheRelativePose) {
  params_.form = MotionForm::kPaper;
  const auto c = constrain("agent_line", node(1, 1.0, Pose3::translation(1, 3, 0)));
  const auto& edge = dynamic_cast<const CEdgeIntraEntity&>(*c.edges.at(0));
  EXPECT_EQ(edge.motion_model, "agent");
  EXPECT_LT((edge.T_1_2.t - Vector3(0, 1, 0)).norm(), kTight);
}

TEST_F(MotionModels, ConsistentLineTiesToTheFirstObservationOnIt) {
  history_ = {node(0, 0.0, Pose3::translation(0, 0, 0)),
              node(1, 1.0, Pose3::translation(1, 0.02, 0)),
              node(2, 2.0, Pose3::translation(2, -0.02, 0))};
  EntityModel model;
  model.direction_entity = Vector3::UnitX();
  const auto c = constrain("agent_line", node(3, 3.0, Pose3::translation(3, 0, 0)), &model);
  const auto& edge = dynamic_cast<const CEdgeAgentLine&>(*c.edges.at(0));
  EXPECT_EQ(edge.nodes, (std::vector<NodeId>{{0}, {3}}));
}

TEST_F(MotionModels, ConsistentLineSkipsAnObservationTakenWhileTurning) {
  history_ = {node(0, 0.0, Pose3::fromYawPitchRoll(0, 0, 0, 1.2, 0, 0)),
              node(1, 1.0, Pose3::translation(0.1, 0, 0))};
  EntityModel model;
  model.direction_entity = Vector3::UnitX();
  const auto c = constrain("agent_line", node(2, 3.0, Pose3::translation(2, 0, 0)), &model);
  const auto& edge = dynamic_cast<const CEdgeAgentLine&>(*c.edges.at(0));
  EXPECT_EQ(edge.nodes.front(), NodeId{1});
}

TEST_F(MotionModels, ConsistentAgentKeepsItsVelocityOverThreeObservations) {
  history_ = {node(0, 0.0, Pose3()), node(1, 0.5, Pose3::translation(0.5, 0, 0))};
  const auto c = constrain("agent", node(2, 1.5, Pose3::translation(1.5, 0, 0)));
  const auto& edge = dynamic_cast<const CEdgeAgentVelocity&>(*c.edges.at(0));
  EXPECT_NEAR(edge.dt_12_s, 0.5, 1e-9);
  EXPECT_NEAR(edge.dt_23_s, 1.0, 1e-9);
  EXPECT_EQ(edge.nodes.size(), 3u);
}

TEST_F(MotionModels, VelocityIsNotCarriedOverALongGap) {
  history_ = {node(0, 0.0, Pose3()), node(1, 0.5, Pose3::translation(0.5, 0, 0))};
  EXPECT_TRUE(constrain("agent", node(2, 30.0, Pose3::translation(9, 0, 0))).edges.empty());
}

TEST(MotionModelNames, FollowTheEntityThenTheClass) {
  EXPECT_EQ(motionModelName(SemanticClass::kObject, nullptr), "object");
  EXPECT_EQ(motionModelName(SemanticClass::kAgent, nullptr), "agent_line");
  EntityModel model;
  model.motion_model = "agent";
  EXPECT_EQ(motionModelName(SemanticClass::kAgent, &model), "agent");
  EXPECT_THROW(motionModels().make("teleport", MotionParams()), ConfigError);
}

}  // namespace
}  // namespace dynemo
