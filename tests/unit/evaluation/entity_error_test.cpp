#include "dynemo/evaluation/entity_error.h"

#include <gtest/gtest.h>

#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-9;

TEST(PoseError, OfDistanceAndAngleByHand) {
  const PoseError e =
      poseError(Pose3::translation(1, 1, 1), Pose3::fromYawPitchRoll(4, 5, 1, 0.5, 0, 0));
  EXPECT_NEAR(e.translation_m, 5.0, kTolerance);
  EXPECT_NEAR(e.rotation_rad, 0.5, kTolerance);
}

TEST(EntityErrors, AreZeroForTruthSeenFromAShiftedMap) {
  const Pose3 T_world_map = Pose3::fromYawPitchRoll(3, -2, 1, 0.8, 0.1, -0.2);
  std::vector<EntityEstimate> estimates;
  for (double t = 1; t < 20; t += 4) {
    for (const auto& [id, truth] : exampleTruths()) {
      estimates.push_back(estimate(estimates.size(), id.value, t,
                                   T_world_map.inverse() * *poseAt(truth.poses, at(t))));
      estimates.back().semantic_class = truth.semantic_class;
    }
  }
  const EntityErrors errors = evaluateEntities(estimates, exampleTruths(), T_world_map);
  ASSERT_EQ(errors.nodes.size(), 15u);
  EXPECT_EQ(errors.without_truth, 0u);
  for (const auto& node : errors.nodes) {
    EXPECT_LT(node.final.translation_m, kTolerance);
    EXPECT_LT(node.final.rotation_rad, 1e-7);
  }
  EXPECT_EQ(finalErrors(errors, SemanticClass::kObject).translation_m.count, 10u);
  EXPECT_EQ(finalErrors(errors, SemanticClass::kAgent).translation_m.count, 5u);
  // The inverse of the alignment must not do.
  EXPECT_GT(evaluateEntities(estimates, exampleTruths(), T_world_map.inverse())
                .nodes[0]
                .final.translation_m,
            0.5);
}

TEST(EntityErrors, TellFirstFromFinalEstimates) {
  auto e = estimate(0, 2, 5.0, Pose3::translation(0, 5.01, 0));
  e.T_map_entity_first = Pose3::translation(0, 5.2, 0);
  const EntityErrors errors = evaluateEntities({e}, exampleTruths(), Pose3());
  EXPECT_NEAR(errors.nodes[0].first.translation_m, 0.2, kTolerance);
  EXPECT_NEAR(errors.nodes[0].final.translation_m, 0.01, kTolerance);
  EXPECT_NEAR(errors.entities.at({2}).first.translation_m.median, 0.2, kTolerance);
}

TEST(EntityErrors, InterpolateTheTruthOfMovingEntities) {
  auto e = estimate(0, 101, 7.5, Pose3::translation(7.6, 0, 0));
  EXPECT_NEAR(evaluateEntities({e}, exampleTruths(), Pose3()).nodes[0].final.translation_m, 0.1,
              kTolerance);
}

TEST(EntityErrors, CountWhatTheTruthDoesNotCover) {
  const EntityErrors errors =
      evaluateEntities({estimate(0, 77, 5, {}), estimate(1, 1, 25, {}), estimate(2, 1, 5, {})},
                       exampleTruths(), Pose3());
  EXPECT_EQ(errors.without_truth, 2u);
  EXPECT_EQ(errors.nodes.size(), 1u);
}

TEST(EntityErrors, JudgeEachPlacementByItsLastNodeAndByTheMedian) {
  const EntityErrors errors = evaluateEntities(
      {
          estimate(0, 1, 1, Pose3::translation(0.30, 0, 0)),
          estimate(1, 1, 5, Pose3::translation(0.10, 0, 0)),
          estimate(2, 1, 3, Pose3::translation(0.20, 0, 0)),
          estimate(3, 1, 15, Pose3::fromYawPitchRoll(2.05, 0, 0, 1.0, 0, 0)),
      },
      exampleTruths(), Pose3());
  ASSERT_EQ(errors.placements.size(), 2u);
  EXPECT_EQ(errors.placements[0].nodes, 3u);
  EXPECT_NEAR(errors.placements[0].last.translation_m, 0.10, kTolerance);
  EXPECT_NEAR(errors.placements[0].median.translation_m, 0.20, kTolerance);
  EXPECT_NEAR(errors.placements[1].last.translation_m, 0.05, kTolerance);
  EXPECT_NEAR(placementErrors(errors).translation_m.max, 0.10, kTolerance);
}

TEST(Nees, IsTheSquaredErrorInStandardDeviations) {
  auto e = estimate(0, 2, 5,
                    Pose3::fromYawPitchRoll(0, 5.0, 0, 1.0, 0, 0) * Pose3::translation(0.02, 0, 0));
  e.T_map_entity.R = Pose3::fromYawPitchRoll(0, 0, 0, 1.0, 0, 0).R;
  Matrix6 covariance = Matrix6::Identity();
  covariance(0, 0) = 1e-4;  // along the entity's own x
  covariance(5, 5) = 0.25;  // about its z
  e.covariance = covariance;
  const EntityErrors errors = evaluateEntities({e}, exampleTruths(), Pose3());
  ASSERT_TRUE(errors.nodes[0].nees);
  EXPECT_NEAR(*errors.nodes[0].nees, 0.02 * 0.02 / 1e-4 + 1.0 / 0.25, 1e-6);
  const NeesSummary summary = neesSummary(errors, SemanticClass::kObject);
  EXPECT_EQ(summary.count, 1u);
  EXPECT_EQ(summary.share_inside, 1.0);  // 8 < 12.6
  EXPECT_EQ(neesSummary(errors, SemanticClass::kAgent).count, 0u);
}

}  // namespace
}  // namespace dynemo::test
