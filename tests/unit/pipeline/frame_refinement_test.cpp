#include "dynemo/pipeline/frame_refinement.h"

#include <gtest/gtest.h>

#include "dynemo/core/noise.h"
#include "frames.h"

namespace dynemo {
namespace {

/// Two keyframes 1 m apart with four frames between them, whose odometry strays to the side and
/// returns; a box in view all the way.
class Gap : public testing::Test {
 protected:
  static constexpr std::size_t kFrames = 6;
  static constexpr double kStray_m = 0.03;

  Gap() {
    params_.acceleration_sigma_m_s2.reset();
    for (std::size_t i : {std::size_t{0}, kFrames - 1}) {
      auto keyframe = std::make_shared<CNodeKeyframe>();
      keyframe->id = graph_.nextNodeId();
      keyframe->stamp = stampOf(i);
      keyframe->T_odom_base = keyframe->T_map_node = truth(i);
      graph_.apply({{keyframe}, {}, {}});
      addBox(keyframe->id, T_map_box_, false);
    }
    for (std::size_t i = 0; i < kFrames; ++i) {
      const bool inside = i > 0 && i + 1 < kFrames;
      const Pose3 T = inside ? Pose3::translation(0, kStray_m, 0) * truth(i) : truth(i);
      frames_.push_back({stampOf(i), T, T});
      measurements_.push_back({isotropicCovariance(0.02, 0.002), {}});
      if (inside) see(i, T_map_box_);
    }
  }

  static Stamp stampOf(std::size_t i) { return test::at(0.1 * static_cast<double>(i)); }
  static Pose3 truth(std::size_t i) {
    return Pose3::translation(0.2 * static_cast<double>(i), 0, 0);
  }
  void addBox(NodeId keyframe, const Pose3& T_map_box, bool moved) {
    auto box = std::make_shared<CNodeEntity>();
    box->id = graph_.nextNodeId();
    box->entity = {7};
    box->keyframe = keyframe;
    box->T_map_node = T_map_box;
    box->moved = moved;
    graph_.apply({{box}, {}, {}});
    covariances_[box->id] = isotropicCovariance(0.001, 0.001);
  }
  void see(std::size_t i, const Pose3& T_map_box) {
    measurements_[i].objects = {
        {{7}, truth(i).inverse() * T_map_box, isotropicCovariance(0.002, 0.01)}};
  }
  /// No objects; odometry that is right but for a jitter to and fro.
  void jitter(double size_m, double sigma_m) {
    for (FrameMeasurements& m : measurements_) m = {isotropicCovariance(sigma_m, 0.002), {}};
    for (std::size_t i = 1; i + 1 < kFrames; ++i) {
      const double y_m = i % 2 == 0 ? size_m : -size_m;
      frames_[i].T_odom_base = frames_[i].T_map_base = Pose3::translation(0, y_m, 0) * truth(i);
    }
    params_.acceleration_sigma_m_s2 = 0.5;
  }
  void refine() { refineFrames(graph_, 0, covariances_, measurements_, params_, frames_); }
  double error(std::size_t i) const { return local(truth(i), frames_[i].T_map_base).norm(); }

  FrameRefinementParams params_;
  CSceneGraph graph_;
  std::map<NodeId, Matrix6> covariances_;
  std::vector<FrameMeasurements> measurements_;
  std::vector<FramePose> frames_;
  const Pose3 T_map_box_ = Pose3::translation(2, 0.5, 0);
};

TEST_F(Gap, ABoxInViewTellsWhereTheFramesAre) {
  refine();
  for (std::size_t i = 1; i + 1 < kFrames; ++i) EXPECT_LT(error(i), 0.3 * kStray_m) << i;
  EXPECT_LT(error(0), 1e-4);
  EXPECT_LT(error(kFrames - 1), 1e-4);
}

TEST_F(Gap, WithoutObjectsNothingMoves) {
  for (FrameMeasurements& m : measurements_) m.objects.clear();
  refine();
  for (std::size_t i = 1; i + 1 < kFrames; ++i) EXPECT_NEAR(error(i), kStray_m, 1e-12);
}

TEST_F(Gap, InertiaTakesTheJitterOutOfNoisyOdometry) {
  jitter(0.02, 0.02);
  refine();
  for (std::size_t i = 1; i + 1 < kFrames; ++i) EXPECT_LT(error(i), 0.5 * 0.02) << i;
}

TEST_F(Gap, PreciseOdometryOutweighsInertia) {
  jitter(0.02, 0.0005);
  const std::vector<FramePose> before = frames_;
  refine();
  for (std::size_t i = 1; i + 1 < kFrames; ++i)
    EXPECT_LT(local(before[i].T_map_base, frames_[i].T_map_base).norm(), 0.1 * 0.02) << i;
}

TEST_F(Gap, AnObjectThatWasMovedInBetweenSaysNothing) {
  graph_ = CSceneGraph();
  for (std::size_t i : {std::size_t{0}, kFrames - 1}) {
    auto keyframe = std::make_shared<CNodeKeyframe>();
    keyframe->id = graph_.nextNodeId();
    keyframe->T_map_node = truth(i);
    graph_.apply({{keyframe}, {}, {}});
    addBox(keyframe->id, T_map_box_, i > 0);
  }
  refine();
  for (std::size_t i = 1; i + 1 < kFrames; ++i) EXPECT_NEAR(error(i), kStray_m, 1e-12);
}

TEST_F(Gap, OneWrongDetectionIsOutvoted) {
  see(3, Pose3::translation(0, 1, 0) * T_map_box_);
  refine();
  for (std::size_t i = 1; i + 1 < kFrames; ++i) EXPECT_LT(error(i), 0.7 * kStray_m) << i;
}

TEST(Sightings, AreOfObjectsAlone) {
  EntityObservation box, human;
  box.entity = {1};
  human.entity = {2};
  human.semantic_class = SemanticClass::kAgent;
  const auto sightings = sightingsOf({box, human});
  ASSERT_EQ(sightings.size(), 1u);
  EXPECT_EQ(sightings[0].entity, EntityId{1});
}

}  // namespace
}  // namespace dynemo
