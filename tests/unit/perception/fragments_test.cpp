#include "dynemo/perception/fragments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "synthetic_scan.h"
#include "tag_scene.h"

namespace dynemo {
namespace {

constexpr double kSigma_m = 0.01;
constexpr double kMinIou = 0.75;

/// A box on the ground 15 cm before a wall, a second box beside it, and a person.
class Fragments : public ::testing::Test {
 protected:
  enum Box { kTarget = 0, kNeighbour = 1, kPerson = 2, kWall = 3, kSideWall = 4 };

  void SetUp() override {
    add(Pose3::translation(3.0, 0.0, 0.25), Vector3(0.25, 0.25, 0.25));
    add(Pose3::translation(2.6, 1.1, 0.3), Vector3(0.3, 0.2, 0.3));
    add(Pose3::translation(-2.0, 0.5, 0.875), Vector3(0.14, 0.23, 0.875));
    add(Pose3::translation(3.46, 0.0, 1.25), Vector3(0.06, 5.0, 1.25));
    add(Pose3::translation(0.0, -4.0, 1.25), Vector3(5.0, 0.06, 1.25));
  }

  void add(const Pose3& T, const Vector3& half) { scene_.boxes.push_back({T, half}); }

  void cast(const Pose3& T_world_base, const Pose3& T_base_lidar) {
    T_world_base_ = T_world_base;
    simulated_ = test::castScan(scene_, T_world_base, T_base_lidar, 64, 1024, kSigma_m);
  }

  EntityObservation see(Box box, SemanticClass semantic_class) const {
    EntityObservation observation;
    observation.entity = EntityId{box};
    observation.semantic_class = semantic_class;
    observation.T_base_entity =
        T_world_base_.inverse() * scene_.boxes[static_cast<std::size_t>(box)].T_world_box;
    return observation;
  }

  static EntityModels targetModels() {
    EntityModel model;
    model.id = EntityId{kTarget};
    model.origin_height_m = 0.25;
    return EntityModels({model});
  }

  double iou(const PointIndices& fragment, Box box) const {
    std::size_t common = 0, all = 0;
    const std::set<std::uint32_t> in_fragment(fragment.begin(), fragment.end());
    for (std::uint32_t i = 0; i < simulated_.box_of_point.size(); ++i) {
      const bool a = in_fragment.contains(i), b = simulated_.box_of_point[i] == box;
      common += a && b ? 1 : 0;
      all += a || b ? 1 : 0;
    }
    return static_cast<double>(common) / static_cast<double>(all);
  }

  test::Scene scene_;
  test::SimulatedScan simulated_;
  Pose3 T_world_base_;
  Pose3 T_base_lidar_ = Pose3::translation(0.0, 0.0, 0.5);
};

TEST_F(Fragments, SeparatesObjectsFromGroundWallAndNeighbour) {
  cast(Pose3::translation(0.0, 0.0, 0.12), T_base_lidar_);
  const auto fragments = extractFragments(
      simulated_.scan,
      {see(kTarget, SemanticClass::kObject), see(kNeighbour, SemanticClass::kObject)}, {});
  ASSERT_EQ(fragments.size(), 2U);
  EXPECT_GT(iou(fragments[0], kTarget), kMinIou);
  EXPECT_GT(iou(fragments[1], kNeighbour), kMinIou);
  EXPECT_TRUE(std::is_sorted(fragments[0].begin(), fragments[0].end()));
}

TEST_F(Fragments, TakesTheWholeHeightOfAnAgent) {
  cast(Pose3::translation(0.0, 0.0, 0.12), T_base_lidar_);
  const auto fragments =
      extractFragments(simulated_.scan, {see(kPerson, SemanticClass::kAgent)}, {});
  EXPECT_GT(iou(fragments[0], kPerson), 0.9);
}

TEST_F(Fragments, ATiltedRobotAndLidarDoNotMatter) {
  const Pose3 tilted = Pose3::fromYawPitchRoll(0.1, -0.2, 1.2, 0.4, 0.06, -0.07);
  cast(tilted, Pose3::fromYawPitchRoll(0.1, 0.0, 0.2, 1.0, 0.1, -0.05));
  const EntityModels models = targetModels();
  FragmentContext context;
  context.models = &models;
  const auto fragments = extractFragments(
      simulated_.scan, {see(kTarget, SemanticClass::kObject), see(kPerson, SemanticClass::kAgent)},
      {}, context);
  EXPECT_GT(iou(fragments[0], kTarget), kMinIou);
  EXPECT_GT(iou(fragments[1], kPerson), kMinIou);
}

TEST_F(Fragments, TheKnownHeightFindsAHiddenGround) {
  // The ground is out of the lidar's sight: the lowest points are the box itself.
  scene_.ground_z = -50.0;
  cast(Pose3::translation(0.0, 0.0, 0.12), T_base_lidar_);
  const EntityModels models = targetModels();
  FragmentContext context;
  context.models = &models;
  const auto fragments =
      extractFragments(simulated_.scan, {see(kTarget, SemanticClass::kObject)}, {}, context);
  EXPECT_GT(iou(fragments[0], kTarget), kMinIou);
}

TEST_F(Fragments, AreEmptyWhereNoClusterIsNear) {
  cast(Pose3::translation(0.0, 0.0, 0.12), T_base_lidar_);
  EntityObservation nothing = see(kTarget, SemanticClass::kObject);
  nothing.T_base_entity.t = Vector3(-1.5, -2.0, 0.3);
  EXPECT_TRUE(extractFragments(simulated_.scan, {nothing}, {})[0].empty());
  nothing.semantic_class = SemanticClass::kAgent;
  EXPECT_TRUE(extractFragments(simulated_.scan, {nothing}, {})[0].empty());
}

TEST_F(Fragments, RespectTheAllowedSizes) {
  cast(Pose3::translation(0.0, 0.0, 0.12), T_base_lidar_);
  const auto target = see(kTarget, SemanticClass::kObject);
  const std::size_t size = extractFragments(simulated_.scan, {target}, {})[0].size();
  ASSERT_GT(size, 20U);
  FragmentParams params;
  params.min_points = static_cast<int>(size) + 1;
  EXPECT_TRUE(extractFragments(simulated_.scan, {target}, params)[0].empty());
  params.min_points = 1;
  params.max_points = static_cast<int>(size) - 1;
  EXPECT_NE(extractFragments(simulated_.scan, {target}, params)[0].size(), size);
}

TEST_F(Fragments, AnEmptyScanHasNone) {
  const auto fragments = extractFragments(
      Scan{}, {see(kTarget, SemanticClass::kObject), see(kPerson, SemanticClass::kAgent)}, {});
  ASSERT_EQ(fragments.size(), 2U);
  EXPECT_TRUE(fragments[0].empty());
  EXPECT_TRUE(fragments[1].empty());
}

TEST_F(Fragments, AreTheSameEveryTime) {
  cast(Pose3::translation(0.0, 0.0, 0.12), T_base_lidar_);
  const auto target = see(kTarget, SemanticClass::kObject);
  EXPECT_EQ(extractFragments(simulated_.scan, {target}, {}),
            extractFragments(simulated_.scan, {target}, {}));
}

}  // namespace
}  // namespace dynemo
