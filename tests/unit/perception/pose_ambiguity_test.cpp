#include "dynemo/perception/pose_ambiguity.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tag_scene.h"

namespace dynemo {
namespace {

using std::numbers::pi;

constexpr double kSameMode_rad = 0.15;

/// A small tag far below the camera's axis, turned away: both minima explain it about equally well,
/// and the wrong one is not upright.
class SmallTag : public ::testing::Test {
 protected:
  void SetUp() override {
    model_.tags.resize(1);
    std::mt19937 generator(1);
    const auto corners = test::visibleCorners(model_, camera_, T_camera_entity_, 0.0, generator);
    ASSERT_EQ(corners.size(), 1U);
    const auto solution = solveEntityPose(model_, camera_, corners, {});
    ASSERT_TRUE(solution);
    solution_ = *solution;
    ASSERT_TRUE(solution_.second);
    ASSERT_GT(apart(solution_.second->T_camera_entity), 2.0 * kSameMode_rad);
  }

  double apart(const Pose3& T) const { return local(T_camera_entity_, T).tail<3>().norm(); }

  /// As if noise had made the wrong minimum the better one.
  EntityPoseSolution deceived() const {
    EntityPoseSolution swapped = solution_;
    std::swap(swapped.best, *swapped.second);
    swapped.best.chi2 = 1.0;
    swapped.second->chi2 = 2.0;
    return swapped;
  }

  /// As if both fitted equally well.
  EntityPoseSolution undecided() const {
    EntityPoseSolution equal = solution_;
    equal.best.chi2 = equal.second->chi2 = 1.0;
    return equal;
  }

  Vector3 up_camera_{0.0, -1.0, 0.0};
  CameraModel camera_ = test::testCamera(DistortionModel::kNone);
  EntityModel model_ = test::boxEntity(EntityId{1}, 0.1, 0.15);
  Pose3 T_camera_entity_ = test::uprightAhead(2.0, pi + 0.45, 0.0, 1.5);
  EntityPoseSolution solution_;
};

TEST_F(SmallTag, TheImageDecidesWhenItsEvidenceSuffices) {
  EntityPoseSolution clear = solution_;
  clear.second->chi2 = clear.best.chi2 + 50.0;
  const auto resolved = resolveAmbiguity(clear, {}, {});
  ASSERT_TRUE(resolved);
  EXPECT_LT(apart(resolved->pose.T_camera_entity), kSameMode_rad);
  EXPECT_TRUE(resolved->decided_without_prediction);
}

TEST_F(SmallTag, LargeResidualsWeakenTheEvidence) {
  EntityPoseSolution poor = solution_;
  poor.best.chi2 = 50.0 * poor.degrees_of_freedom;
  poor.second->chi2 = poor.best.chi2 + 50.0;
  EXPECT_FALSE(resolveAmbiguity(poor, {}, {}));
}

TEST_F(SmallTag, WithoutAnyPriorItIsRejected) {
  const auto resolved = resolveAmbiguity(undecided(), {}, {});
  ASSERT_FALSE(resolved);
  EXPECT_EQ(resolved.error(), TagPoseFailure::kAmbiguous);
}

TEST_F(SmallTag, UprightnessDecides) {
  OrientationPrior prior;
  prior.up_camera = up_camera_;
  for (const EntityPoseSolution& solution : {undecided(), deceived()}) {
    const auto resolved = resolveAmbiguity(solution, prior, {});
    ASSERT_TRUE(resolved);
    EXPECT_LT(apart(resolved->pose.T_camera_entity), kSameMode_rad);
    EXPECT_TRUE(resolved->decided_without_prediction);
  }
}

TEST_F(SmallTag, AFallenEntityIsNotForcedUpright) {
  OrientationPrior prior;
  prior.up_camera = Vector3(0.0, 0.0, -1.0);  // both minima lie on their side
  EXPECT_FALSE(resolveAmbiguity(undecided(), prior, {}));
}

TEST_F(SmallTag, TheLastObservationDecidesButDoesNotPerpetuateItself) {
  OrientationPrior prior;
  prior.R_camera_entity = T_camera_entity_.R * expSO3(Vector3(0.0, 0.0, 0.05));
  AmbiguityParams params;
  params.prediction_sigma_rad = 0.1;
  const auto resolved = resolveAmbiguity(deceived(), prior, params);
  ASSERT_TRUE(resolved);
  EXPECT_LT(apart(resolved->pose.T_camera_entity), kSameMode_rad);
  EXPECT_FALSE(resolved->decided_without_prediction);
}

TEST_F(SmallTag, InflationCoversBothMinima) {
  AmbiguityParams params;
  params.fallback = AmbiguityParams::Fallback::kInflate;
  const EntityPoseSolution solution = undecided();
  const auto resolved = resolveAmbiguity(solution, {}, params);
  ASSERT_TRUE(resolved);
  EXPECT_FALSE(resolved->decided_without_prediction);
  const Vector6 apart_from_other =
      local(solution.best.T_camera_entity, solution.second->T_camera_entity);
  const double along =
      apart_from_other.normalized().dot(resolved->pose.covariance * apart_from_other.normalized());
  EXPECT_GT(along, 0.49 * apart_from_other.squaredNorm());
}

TEST(PoseAmbiguity, ASingleMinimumNeedsNoDecision) {
  EntityPoseSolution solution;
  solution.best.T_camera_entity = test::uprightAhead(1.0, 0.3);
  const auto resolved = resolveAmbiguity(solution, {}, {});
  ASSERT_TRUE(resolved);
  EXPECT_EQ(resolved->pose.T_camera_entity.t, solution.best.T_camera_entity.t);
}

}  // namespace
}  // namespace dynemo
