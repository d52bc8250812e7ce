#include "dynemo/perception/tag_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynemo/core/noise.h"
#include "tag_scene.h"

namespace dynemo {
namespace {

using std::numbers::pi;

constexpr double kExactTolerance = 1e-6;

class EveryLensSolved : public ::testing::TestWithParam<DistortionModel> {};

TEST_P(EveryLensSolved, RecoversThePoseFromExactCorners) {
  const CameraModel camera = test::testCamera(GetParam());
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(1);
  for (const double yaw : {pi - 0.5, pi + 0.3, 0.4, pi / 2 + 0.2}) {
    const Pose3 T_camera_entity = test::uprightAhead(2.0, yaw, 0.4);
    const auto corners = test::visibleCorners(box, camera, T_camera_entity, 0.0, generator);
    const auto solution = solveEntityPose(box, camera, corners, {});
    ASSERT_TRUE(solution) << text(solution.error());
    EXPECT_LT(local(T_camera_entity, solution->best.T_camera_entity).norm(), kExactTolerance);
    EXPECT_EQ(solution->used_tags.size(), corners.size());
    EXPECT_TRUE(solution->rejected_tags.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, EveryLensSolved,
                         ::testing::Values(DistortionModel::kNone, DistortionModel::kPlumbBob,
                                           DistortionModel::kKannalaBrandt));

/// Corner noise that does not depend on the tag's size, so that the covariance can be compared with
/// the errors.
TagPoseParams fixedNoise(double sigma_px) {
  TagPoseParams params;
  params.corner_sigma_base_px = sigma_px;
  params.corner_sigma_slope_px2 = 0.0;
  return params;
}

TEST(TagPose, CovarianceMatchesTheScatterOfTheErrors) {
  constexpr int kDraws = 400;
  constexpr double kSigma_px = 0.1;
  const CameraModel camera = test::testCamera(DistortionModel::kPlumbBob);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> yaw(-pi, pi), distance(1.2, 3.0), left(-0.4, 0.4);
  double nees = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const Pose3 T = test::uprightAhead(distance(generator), yaw(generator), left(generator));
    const auto corners = test::visibleCorners(box, camera, T, kSigma_px, generator);
    const auto solution = solveEntityPose(box, camera, corners, fixedNoise(kSigma_px));
    ASSERT_TRUE(solution) << text(solution.error());
    // Of the two minima of a single tag take the true one: choosing is tested elsewhere.
    Vector6 error = local(T, solution->best.T_camera_entity);
    Matrix6 covariance = solution->best.covariance;
    if (solution->second && local(T, solution->second->T_camera_entity).norm() < error.norm()) {
      error = local(T, solution->second->T_camera_entity);
      covariance = solution->second->covariance;
    }
    nees += squaredMahalanobis(error, covariance) / kDraws;
  }
  EXPECT_GT(nees / 6.0, 0.6);
  EXPECT_LT(nees / 6.0, 1.2);
}

TEST(TagPose, ResidualsLargerThanTheNoiseModelWidenTheCovariance) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(3);
  const auto corners =
      test::visibleCorners(box, camera, test::uprightAhead(2.0, pi + 0.6), 0.8, generator);
  const auto believing = solveEntityPose(box, camera, corners, fixedNoise(0.8));
  const auto surprised = solveEntityPose(box, camera, corners, fixedNoise(0.1));
  ASSERT_TRUE(believing && surprised);
  EXPECT_GT(surprised->best.covariance.trace(), 10.0 * believing->best.covariance.trace() / 64.0);
}

TEST(TagPose, TwoTagsAreMoreCertainThanOne) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(4);
  auto corners =
      test::visibleCorners(box, camera, test::uprightAhead(2.0, pi + 0.8), 0.0, generator);
  ASSERT_EQ(corners.size(), 2U);
  const auto both = solveEntityPose(box, camera, corners, {});
  corners.pop_back();
  const auto one = solveEntityPose(box, camera, corners, {});
  ASSERT_TRUE(both && one);
  EXPECT_LT(both->best.covariance.trace(), 0.5 * one->best.covariance.trace());
}

/// A board with three tags side by side, so that all are seen at once.
EntityModel board() {
  EntityModel model;
  model.id = EntityId{2};
  for (int i = 0; i < 3; ++i) {
    model.tags.push_back(
        test::faceTag(10 + i, 0.2, Vector3(0.05 * i, 0.3 * (i - 1), 0.1 * i), Vector3::UnitX()));
  }
  return model;
}

TEST(TagPose, OneMisplacedTagIsOutvoted) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const Pose3 T = test::uprightAhead(2.0, pi + 0.4);
  std::mt19937 generator(5);
  auto corners = test::visibleCorners(board(), camera, T, 0.0, generator);
  ASSERT_EQ(corners.size(), 3U);
  for (Vector2& corner : corners[1].corners_px) corner += Vector2(15.0, -4.0);
  const auto solution = solveEntityPose(board(), camera, corners, {});
  ASSERT_TRUE(solution) << text(solution.error());
  EXPECT_EQ(solution->rejected_tags, std::vector<int>{11});
  EXPECT_EQ(solution->used_tags, (std::vector<int>{10, 12}));
  EXPECT_LT(local(T, solution->best.T_camera_entity).norm(), kExactTolerance);
}

TEST(TagPose, TwoTagsThatContradictEachOtherGiveNoPose) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(6);
  auto corners =
      test::visibleCorners(box, camera, test::uprightAhead(2.0, pi + 0.8), 0.0, generator);
  ASSERT_EQ(corners.size(), 2U);
  for (Vector2& corner : corners[1].corners_px) corner += Vector2(40.0, 10.0);
  const auto solution = solveEntityPose(box, camera, corners, {});
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error(), TagPoseFailure::kInconsistentTags);
}

TEST(TagPose, ACornerFarOffIsRejected) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(7);
  auto corners =
      test::visibleCorners(box, camera, test::uprightAhead(2.0, pi + 0.1), 0.0, generator);
  ASSERT_EQ(corners.size(), 1U);
  const Vector2 diagonal = corners[0].corners_px[2] - corners[0].corners_px[0];
  corners[0].corners_px[2] += 0.6 * diagonal;
  TagPoseParams params;
  params.max_reprojection_px = 0.5;
  const auto exact = solveEntityPose(box, camera, corners, params);
  // A convex quadrilateral with right-angled views excluded has no exact square pose in general.
  ASSERT_FALSE(exact);
  EXPECT_EQ(exact.error(), TagPoseFailure::kReprojection);
}

TEST(TagPose, UnusableTagsAreNoPose) {
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(8);
  const auto good = test::visibleCorners(box, camera, test::uprightAhead(2.0, pi), 0.0, generator);
  const auto expectUnusable = [&](std::vector<TagCornerObservation> corners,
                                  const TagPoseParams& params, const CameraModel& with) {
    const auto solution = solveEntityPose(box, with, corners, params);
    ASSERT_FALSE(solution);
    EXPECT_EQ(solution.error(), TagPoseFailure::kNoUsableTag);
  };
  expectUnusable({}, {}, camera);
  expectUnusable(good, {}, CameraModel{});
  TagPoseParams large_only;
  large_only.min_edge_px = 200.0;
  expectUnusable(good, large_only, camera);
  auto foreign = good;
  foreign[0].tag_id = 77;
  expectUnusable(foreign, {}, camera);
  auto crossed = good;
  std::swap(crossed[0].corners_px[0], crossed[0].corners_px[1]);
  expectUnusable(crossed, {}, camera);
  auto broken = good;
  broken[0].corners_px[3].x() = NAN;
  expectUnusable(broken, {}, camera);
  auto flat = good;
  for (Vector2& corner : flat[0].corners_px) corner = Vector2(100.0, 100.0);
  expectUnusable(flat, {}, camera);
}

}  // namespace
}  // namespace dynemo
