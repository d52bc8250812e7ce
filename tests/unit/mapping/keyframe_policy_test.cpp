#include "dynemo/mapping/keyframe_policy.h"

#include <gtest/gtest.h>

#include "dynemo/core/noise.h"

namespace dynemo {
namespace {

bool has(std::uint32_t reasons, KeyframeReason reason) {
  return reasons & static_cast<std::uint32_t>(reason);
}

class Policy : public testing::Test {
 protected:
  void addKeyframe(double t_s, const Pose3& T_odom_base) {
    auto keyframe = std::make_shared<CNodeKeyframe>();
    keyframe->id = graph_.nextNodeId();
    keyframe->stamp = Stamp::fromSeconds(t_s);
    keyframe->T_odom_base = keyframe->T_map_node = T_odom_base;
    graph_.apply({{keyframe}, {}, {}});
  }
  void addEntity(int id, SemanticClass c, double t_s, const Pose3& T_map_entity) {
    auto entity = std::make_shared<CNodeEntity>();
    entity->id = graph_.nextNodeId();
    entity->entity = {id};
    entity->semantic_class = c;
    entity->stamp = Stamp::fromSeconds(t_s);
    entity->T_map_node = T_map_entity;
    graph_.apply({{entity}, {}, {}});
  }
  EntityObservation see(int id, SemanticClass c, double t_s, const Pose3& T_base_entity) {
    EntityObservation o;
    o.entity = {id};
    o.semantic_class = c;
    o.stamp = Stamp::fromSeconds(t_s);
    o.T_base_entity = T_base_entity;
    o.covariance = isotropicCovariance(0.02, 0.03);
    return o;
  }
  std::uint32_t decide(double t_s, const Pose3& T_odom_base,
                       const std::vector<EntityObservation>& observations = {}) {
    return policy_.decide({Stamp::fromSeconds(t_s), T_odom_base, T_odom_base, observations},
                          graph_);
  }

  KeyframeParams params_;
  KeyframePolicy policy_{params_};
  CSceneGraph graph_;
};

TEST_F(Policy, TheFirstFrameIsAKeyframe) {
  EXPECT_TRUE(has(decide(0, Pose3()), KeyframeReason::kFirst));
}

TEST_F(Policy, RobotMotionIsTestedByTranslationAndByRotation) {
  addKeyframe(0, Pose3());
  EXPECT_EQ(decide(1, Pose3::translation(0.45, 0, 0)), 0u);
  EXPECT_TRUE(has(decide(2, Pose3::translation(0.55, 0, 0)), KeyframeReason::kRobotMoved));
  EXPECT_EQ(decide(3, Pose3::fromYawPitchRoll(0, 0, 0, 0.25, 0, 0)), 0u);
  EXPECT_TRUE(
      has(decide(4, Pose3::fromYawPitchRoll(0, 0, 0, 0.27, 0, 0)), KeyframeReason::kRobotMoved));
}

TEST_F(Policy, ANewEntityMustBeSeenTwice) {
  addKeyframe(0, Pose3());
  const Pose3 T = Pose3::translation(3, 0, 0);
  EXPECT_EQ(decide(1.0, Pose3(), {see(5, SemanticClass::kObject, 1.0, T)}), 0u);
  EXPECT_TRUE(has(decide(1.2, Pose3(), {see(5, SemanticClass::kObject, 1.2, T)}),
                  KeyframeReason::kNewEntity));
}

TEST_F(Policy, TwoSightingsAtDifferentPlacesDoNotConfirmEachOther) {
  addKeyframe(0, Pose3());
  EXPECT_EQ(
      decide(1.0, Pose3(), {see(5, SemanticClass::kObject, 1.0, Pose3::translation(3, 0, 0))}), 0u);
  EXPECT_EQ(
      decide(1.2, Pose3(), {see(5, SemanticClass::kObject, 1.2, Pose3::translation(5, 0, 0))}), 0u);
}

TEST_F(Policy, ADisplacedObjectMakesAKeyframe) {
  addKeyframe(0, Pose3());
  addEntity(5, SemanticClass::kObject, 0, Pose3::translation(3, 0, 0));
  const Pose3 T_moved = Pose3::translation(3.5, 0, 0);
  EXPECT_EQ(decide(1.0, Pose3(), {see(5, SemanticClass::kObject, 1.0, T_moved)}), 0u);
  EXPECT_TRUE(has(decide(1.2, Pose3(), {see(5, SemanticClass::kObject, 1.2, T_moved)}),
                  KeyframeReason::kEntityMoved));
}

TEST_F(Policy, ADisplacementWithinTheDetectionNoiseDoesNot) {
  addKeyframe(0, Pose3());
  addEntity(5, SemanticClass::kObject, 0, Pose3::translation(3, 0, 0));
  for (double t_s : {1.0, 1.2, 1.4}) {
    auto o = see(5, SemanticClass::kObject, t_s, Pose3::translation(3.5, 0, 0));
    o.covariance = isotropicCovariance(0.5, 0.5);
    EXPECT_EQ(decide(t_s, Pose3(), {o}), 0u);
  }
}

TEST_F(Policy, TheTimerOfAStaticObjectMakesAKeyframeButNotAnAgents) {
  addKeyframe(0, Pose3());
  addEntity(5, SemanticClass::kObject, 0, Pose3::translation(3, 0, 0));
  addEntity(6, SemanticClass::kAgent, 0, Pose3::translation(3, 1, 0));
  const auto agent = [&](double t_s) {
    return see(6, SemanticClass::kAgent, t_s, Pose3::translation(3, 1, 0));
  };
  EXPECT_EQ(decide(4.9, Pose3(),
                   {see(5, SemanticClass::kObject, 4.9, Pose3::translation(3, 0, 0)), agent(4.9)}),
            0u);
  EXPECT_EQ(decide(5.1, Pose3(), {agent(5.1)}), 0u);
  EXPECT_TRUE(
      has(decide(5.2, Pose3(), {see(5, SemanticClass::kObject, 5.2, Pose3::translation(3, 0, 0))}),
          KeyframeReason::kTimerExpired));
}

TEST_F(Policy, EntitiesTriggerNoFasterThanTheMinimumInterval) {
  addKeyframe(1.0, Pose3());
  const auto walker = [&](double t_s) {
    return see(6, SemanticClass::kAgent, t_s, Pose3::translation(3, t_s, 0));
  };
  EXPECT_EQ(decide(1.1, Pose3(), {walker(1.1)}), 0u);
  EXPECT_EQ(decide(1.3, Pose3(), {walker(1.3)}), 0u);
  EXPECT_NE(decide(1.6, Pose3(), {walker(1.6)}), 0u);
}

TEST_F(Policy, TheBaselineIgnoresEntities) {
  params_.mode = KeyframeMode::kBaseline;
  policy_ = KeyframePolicy(params_);
  addKeyframe(0, Pose3());
  for (double t_s : {1.0, 1.2, 1.4}) {
    EXPECT_EQ(
        decide(t_s, Pose3(), {see(5, SemanticClass::kObject, t_s, Pose3::translation(3, 0, 0))}),
        0u);
  }
}

}  // namespace
}  // namespace dynemo
