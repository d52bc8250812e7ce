#include "dynemo/pipeline/slam_pipeline.h"

#include <gtest/gtest.h>

#include "dynemo/core/error.h"
#include "frames.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

using test::at;
using test::driveWithWrongScale;
using test::externalOnly;
using test::frameAt;
using test::process;
using test::see;

constexpr int kFrames = 40;

class Drive : public testing::Test {
 protected:
  void drive(DynemoParams params = externalOnly()) {
    pipeline_ = std::make_unique<SlamPipeline>(params, models_, true);
    driveWithWrongScale(*pipeline_, kFrames);
    pipeline_->finish();
  }
  /// The keyframe made of a frame, or nullptr.
  const CNodeKeyframe* keyframeOf(std::size_t frame) const {
    for (const auto& keyframe : pipeline_->graph().keyframes()) {
      if (keyframe->frame_index == frame) return keyframe.get();
    }
    return nullptr;
  }

  EntityModels models_;
  std::unique_ptr<SlamPipeline> pipeline_;
};

TEST_F(Drive, EveryFrameHasAPose) {
  drive();
  ASSERT_EQ(pipeline_->frames().size(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 0; i < pipeline_->frames().size(); ++i)
    EXPECT_EQ(pipeline_->frames()[i].stamp, at(0.2 * static_cast<double>(i)));
}

TEST_F(Drive, TheBoxCorrectsTheScaleOfTheOdometry) {
  drive();
  const FramePose& last = pipeline_->frames().back();
  const double driven_m = 0.2 * (kFrames - 1);
  const double drift_m = std::abs(last.T_odom_base.t.x() - driven_m);
  EXPECT_GT(drift_m, 0.3);
  EXPECT_LT(std::abs(last.T_map_base.t.x() - driven_m), 0.4 * drift_m);
}

TEST_F(Drive, FramesAtKeyframesAreTheKeyframes) {
  drive();
  std::size_t keyframes = 0;
  for (std::size_t i = 0; i < pipeline_->frames().size(); ++i) {
    const CNodeKeyframe* keyframe = keyframeOf(i);
    if (!keyframe) continue;
    ++keyframes;
    EXPECT_LT(local(keyframe->T_map_base(), pipeline_->frames()[i].T_map_base).norm(), 1e-9);
  }
  EXPECT_EQ(keyframes, pipeline_->graph().keyframes().size());
  EXPECT_GE(keyframes, 5u);
}

TEST_F(Drive, TheBoxAlsoPlacesTheFramesBetweenKeyframes) {
  const auto error_m = [&] {
    double sum_m2 = 0.0;
    for (std::size_t i = 0; i < pipeline_->frames().size(); ++i) {
      const double x_m = pipeline_->frames()[i].T_map_base.t.x();
      sum_m2 += std::pow(x_m - 0.2 * static_cast<double>(i), 2);
    }
    return std::sqrt(sum_m2 / kFrames);
  };
  DynemoParams params = externalOnly();
  params.keyframes.robot_translation_m = 2.0;
  params.keyframes.timer = false;
  params.trajectory.objects = false;
  drive(params);
  const double blended_m = error_m();
  params.trajectory.objects = true;
  drive(params);
  EXPECT_LT(error_m(), blended_m);
}

TEST_F(Drive, BetweenKeyframesTheCorrectionIsBlendedByTime) {
  DynemoParams params = externalOnly();
  params.trajectory.objects = false;
  params.trajectory.acceleration_sigma_m_s2.reset();
  drive(params);
  const auto& frames = pipeline_->frames();
  const auto& keyframes = pipeline_->graph().keyframes();
  std::size_t checked = 0;
  for (std::size_t k = 0; k + 1 < keyframes.size(); ++k) {
    const CNodeKeyframe &a = *keyframes[k], &b = *keyframes[k + 1];
    // The motion is along x alone, so that the correction of a frame is a number.
    const double correction_a = a.T_map_base().t.x() - a.T_odom_base.t.x();
    const double correction_b = b.T_map_base().t.x() - b.T_odom_base.t.x();
    for (std::size_t i = a.frame_index + 1; i < b.frame_index; ++i) {
      const double s = static_cast<double>(i - a.frame_index) /
                       static_cast<double>(b.frame_index - a.frame_index);
      const double expected = (1 - s) * correction_a + s * correction_b;
      EXPECT_NEAR(frames[i].T_map_base.t.x() - frames[i].T_odom_base.t.x(), expected, 1e-4);
      ++checked;
    }
    EXPECT_GT(std::abs(correction_b - correction_a), 1e-3) << "nothing to blend";
  }
  EXPECT_GT(checked, 10u);
}

TEST_F(Drive, AfterTheLastKeyframeTheOdometryContinuesFromIt) {
  DynemoParams params = externalOnly();
  params.keyframes.robot_translation_m = 0.75;
  params.trajectory.objects = false;
  params.trajectory.acceleration_sigma_m_s2.reset();
  drive(params);
  const CNodeKeyframe& last = *pipeline_->graph().keyframes().back();
  const FramePose& frame = pipeline_->frames().back();
  ASSERT_NE(keyframeOf(kFrames - 1), &last) << "the last frame must lie beyond the last keyframe";
  const Pose3 expected = last.T_map_base() * (last.T_odom_base.inverse() * frame.T_odom_base);
  EXPECT_LT(local(expected, frame.T_map_base).norm(), 1e-9);
}

TEST_F(Drive, TheDriftIsTheNewestKeyframes) {
  drive();
  const CNodeKeyframe& last = *pipeline_->graph().keyframes().back();
  EXPECT_LT(local(last.T_map_base(), pipeline_->graph().T_map_odom * last.T_odom_base).norm(),
            1e-9);
  ASSERT_TRUE(pipeline_->driftCovariance());
  EXPECT_GT((*pipeline_->driftCovariance())(0, 0), 0.0);
}

TEST_F(Drive, ATrajectoryInTheMiddleOfARunIsUpToDate) {
  pipeline_ = std::make_unique<SlamPipeline>(externalOnly(), models_, true);
  driveWithWrongScale(*pipeline_, kFrames);
  const double before = pipeline_->frames()[kFrames / 2].T_map_base.t.x();
  pipeline_->updateTrajectory();
  for (std::size_t i = 0; i < kFrames; ++i) {
    const CNodeKeyframe* keyframe = keyframeOf(i);
    if (!keyframe) continue;
    EXPECT_LT(local(keyframe->T_map_base(), pipeline_->frames()[i].T_map_base).norm(), 1e-9);
  }
  EXPECT_NE(pipeline_->frames()[kFrames / 2].T_map_base.t.x(), before);
}

TEST_F(Drive, TheBaselineKeepsTheOdometry) {
  DynemoParams params = externalOnly();
  params.mapping.keyframe_entity = false;
  drive(params);
  EXPECT_TRUE(pipeline_->graph().tracks().empty());
  for (const FramePose& frame : pipeline_->frames())
    EXPECT_LT(local(frame.T_odom_base, frame.T_map_base).norm(), 1e-6);
}

TEST_F(Drive, TwoRunsAreEqual) {
  drive();
  const auto first = std::move(pipeline_);
  drive();
  ASSERT_EQ(first->frames().size(), pipeline_->frames().size());
  for (std::size_t i = 0; i < first->frames().size(); ++i) {
    EXPECT_EQ(first->frames()[i].T_map_base.t, pipeline_->frames()[i].T_map_base.t);
    EXPECT_EQ(first->frames()[i].T_map_base.R, pipeline_->frames()[i].T_map_base.R);
  }
}

TEST(SlamPipeline, NothingIsDoneWithoutFrames) {
  const EntityModels models;
  SlamPipeline pipeline(DynemoParams(), models, true);
  pipeline.finish();
  pipeline.updateTrajectory();
  EXPECT_TRUE(pipeline.frames().empty());
}

/// A robot in a room that begins to turn, by a LiDAR that takes a tenth of a second for a sweep.
class TurningRobot : public testing::Test {
 protected:
  static Pose3 poseAt(double t) {
    const double since_s = std::max(0.0, t - 0.15);
    return Pose3::fromYawPitchRoll(0.3 * t, 0.2, 0.8, 1.2 * since_s, 0, 0);
  }

  /// Largest distance of the points of the second frame's keyframe from the room's faces.
  double largestError(KeyframeDeskew deskew) const {
    DynemoParams params = externalOnly();
    params.keyframes.deskew = deskew;
    params.keyframes.robot_translation_m = 0.01;
    const EntityModels models;
    SlamPipeline pipeline(params, models, true);
    test::LidarModel lidar;
    lidar.rows = 8;
    lidar.columns = 180;
    lidar.sigma_m = 0.0;
    std::mt19937_64 random(1);
    for (const double t : {0.0, 0.1, 0.2, 0.3}) {
      SensorFrame frame = frameAt(t, poseAt(0.0).inverse() * poseAt(t));
      frame.scan = test::sweep(room_, lidar, poseAt, t, random);
      frame.scan->stamp = frame.stamp;
      process(pipeline, std::move(frame));
    }
    pipeline.finish();
    EXPECT_EQ(pipeline.frames().size(), 4u);
    EXPECT_EQ(pipeline.graph().keyframes().size(), 4u);
    double largest_m = 0.0;
    const Scan& scan = *pipeline.graph().keyframes()[2]->scan;
    for (const auto& point : scan.cloud.points) {
      const Vector3 p = poseAt(0.2) * (scan.T_base_lidar * point.cast<double>());
      const Vector3 to_faces = kHalf - (p - Vector3(0, 0, 1)).cwiseAbs();
      largest_m = std::max(largest_m, to_faces.cwiseAbs().minCoeff());
    }
    return largest_m;
  }

  const Vector3 kHalf{6, 4, 1};
  const test::World room_ = {{test::Box{Pose3::translation(0, 0, 1), kHalf}}};
};

TEST_F(TurningRobot, SweepsAreStraightenedByTheMotionUntilTheNextFrame) {
  EXPECT_LT(largestError(KeyframeDeskew::kNextFrame), 0.01);
  EXPECT_GT(largestError(KeyframeDeskew::kPast), 0.1);
  EXPECT_GT(largestError(KeyframeDeskew::kNone), 0.2);
}

TEST(SlamPipeline, APrefilterMustBeAKnownOne) {
  DynemoParams params;
  params.loops.prefilter.method = "sometimes";
  const EntityModels models;
  EXPECT_THROW(SlamPipeline(params, models, true), ConfigError);
}

TEST(SlamPipeline, AnObjectThatIsCarriedAwayIsFlaggedAndOthersAreNot) {
  const EntityModels models;
  SlamPipeline pipeline(externalOnly(), models, true);
  for (int i = 0; i < 40; ++i) {
    SensorFrame frame = frameAt(0.2 * i, Pose3::translation(0.1 * i, 0, 0));
    frame.index = static_cast<std::uint64_t>(i);
    const Pose3 T_base_map = frame.odometry->T_odom_base.inverse();
    see(frame, 1, T_base_map * Pose3::translation(8, 1, 0));
    see(frame, 2, T_base_map * Pose3::translation(8, i < 20 ? -1 : -2, 0));
    process(pipeline, std::move(frame));
  }
  pipeline.finish();
  const auto moves = [&](int id) {
    const auto& track = pipeline.graph().tracks().at({id});
    return std::count_if(track.begin(), track.end(), [](const auto& node) { return node->moved; });
  };
  EXPECT_EQ(moves(1), 0);
  EXPECT_EQ(moves(2), 1);
  constexpr double kTolerance_m = 0.01;
  EXPECT_NEAR(pipeline.graph().lastObservation({2})->T_map_entity().t.y(), -2.0, kTolerance_m);
}

}  // namespace
}  // namespace dynemo
