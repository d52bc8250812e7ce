#include "dynemo/mapping/localize.h"

#include <gtest/gtest.h>

#include "dynemo/core/noise.h"

namespace dynemo {
namespace {

class Localize : public testing::Test {
 protected:
  void map(int id, SemanticClass c, const Pose3& T_map_entity) {
    auto entity = std::make_shared<CNodeEntity>();
    entity->id = graph_.nextNodeId();
    entity->entity = {id};
    entity->semantic_class = c;
    entity->T_map_node = T_map_entity;
    graph_.apply({{entity}, {}, {}});
  }
  void see(int id, SemanticClass c, const Pose3& T_base_entity, double sigma_m = 0.02) {
    EntityObservation o;
    o.entity = {id};
    o.semantic_class = c;
    o.T_base_entity = T_base_entity;
    o.covariance = isotropicCovariance(sigma_m, 0.03);
    observations_.push_back(o);
  }
  CSceneGraph graph_;
  std::vector<EntityObservation> observations_;
  const Pose3 T_map_base_ = Pose3::fromYawPitchRoll(2, 1, 0.1, 0.7, 0.02, -0.01);
};

TEST_F(Localize, RecoversThePoseFromExactObservations) {
  for (int i = 0; i < 3; ++i) {
    const Pose3 T = Pose3::fromYawPitchRoll(i, 3 - i, 0.2, 0.5 * i, 0, 0);
    map(i, SemanticClass::kObject, T);
    see(i, SemanticClass::kObject, T_map_base_.inverse() * T);
  }
  const auto T = localizeFromEntities(observations_, graph_);
  ASSERT_TRUE(T);
  EXPECT_LT(local(T_map_base_, *T).norm(), 1e-9);
}

TEST_F(Localize, OneMovedObjectAmongFiveDoesNotDecide) {
  for (int i = 0; i < 5; ++i) {
    const Pose3 T = Pose3::translation(i, 2, 0);
    map(i, SemanticClass::kObject, T);
    see(i, SemanticClass::kObject,
        T_map_base_.inverse() * Pose3::translation(i == 2 ? 1.0 : 0.0, 0, 0) * T,
        i == 2 ? 0.03 : 0.02);
  }
  EXPECT_LT(local(T_map_base_, *localizeFromEntities(observations_, graph_)).norm(), 0.05);
}

TEST_F(Localize, AgentsOnlyServeWhereNoObjectDoes) {
  map(1, SemanticClass::kObject, Pose3::translation(1, 0, 0));
  map(2, SemanticClass::kAgent, Pose3::translation(5, 0, 0));
  see(2, SemanticClass::kAgent, Pose3::translation(3, 0, 0));
  EXPECT_NEAR(localizeFromEntities(observations_, graph_)->t.x(), 2.0, 1e-9);
  see(1, SemanticClass::kObject, Pose3::translation(1, 0, 0));
  EXPECT_NEAR(localizeFromEntities(observations_, graph_)->t.x(), 0.0, 1e-9);
}

TEST_F(Localize, NothingKnownGivesNothing) {
  EXPECT_FALSE(localizeFromEntities(observations_, graph_));
  see(9, SemanticClass::kObject, Pose3());
  EXPECT_FALSE(localizeFromEntities(observations_, graph_));
}

}  // namespace
}  // namespace dynemo
