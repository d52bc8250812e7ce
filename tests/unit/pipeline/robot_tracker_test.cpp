#include "dynemo/pipeline/robot_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numeric>

#include "dynemo/core/error.h"
#include "frames.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

using test::at;
using test::frameAt;

RobotOdometryParams withSource(OdometrySource source) {
  RobotOdometryParams params;
  params.source = source;
  params.lidar.threads = 1;
  return params;
}

/// A room with walls askew and a pillar, seen from T_world_base by a LiDAR on top of the robot.
Scan roomScan(double seconds, const Pose3& T_world_base) {
  Scan scan;
  scan.stamp = at(seconds);
  scan.T_base_lidar = Pose3::fromYawPitchRoll(0.1, 0, 0.4, 0.3, 0, 0);
  const Pose3 T_lidar_world = (T_world_base * scan.T_base_lidar).inverse();
  const auto add = [&](double x, double y, double z) {
    scan.cloud.points.push_back((T_lidar_world * Vector3(x, y, z)).cast<float>());
  };
  constexpr double kSpacing_m = 0.15;
  for (double a = -4; a <= 4; a += kSpacing_m) {
    for (double b = -4; b <= 4; b += kSpacing_m) add(a, b, -0.1);
    for (double z = -0.1; z < 2.4; z += kSpacing_m) {
      add(a, 4, z);
      add(a, -4, z);
      add(4 + 0.2 * a, a, z);
      add(-4, a, z);
    }
  }
  for (double angle = 0; angle < 6.2; angle += 0.2) {
    for (double z = -0.1; z < 2; z += kSpacing_m)
      add(2 + 0.3 * std::cos(angle), 1 + 0.3 * std::sin(angle), z);
  }
  return scan;
}

SensorFrame scanFrame(double seconds, const Pose3& T_world_base) {
  SensorFrame frame;
  frame.stamp = at(seconds);
  frame.scan = roomScan(seconds, T_world_base);
  return frame;
}

/// A graph with one keyframe at the origin and one box.
CSceneGraph graphWithBox(const Pose3& T_map_box) {
  auto keyframe = std::make_shared<CNodeKeyframe>();
  keyframe->id = {0};
  keyframe->stamp = at(0);
  auto box = std::make_shared<CNodeEntity>();
  box->id = {1};
  box->entity = {7};
  box->T_map_node = T_map_box;
  CSceneGraph graph;
  graph.apply({{keyframe, box}, {}, {}});
  return graph;
}

EntityObservation observation(const Pose3& T_base_entity) {
  EntityObservation o;
  o.entity = {7};
  o.stamp = at(1);
  o.T_base_entity = T_base_entity;
  o.covariance = isotropicCovariance(0.01, 0.01);
  return o;
}

TEST(RobotTracker, OdometryThatIsAskedForMustBeThere) {
  EXPECT_THROW(RobotTracker(withSource(OdometrySource::kRawlog), false), ConfigError);
  EXPECT_NO_THROW(RobotTracker(withSource(OdometrySource::kRawlog), true));
  EXPECT_NO_THROW(RobotTracker(withSource(OdometrySource::kAuto), false));
}

TEST(RobotTracker, TakesTheRecordedOdometryAsItIs) {
  RobotTracker tracker(withSource(OdometrySource::kAuto), true);
  const Pose3 T_odom_base = Pose3::fromYawPitchRoll(1, 2, 0.1, 0.3, 0.01, 0.02);
  SensorFrame frame = scanFrame(0, Pose3());
  frame.odometry = OdometryState{T_odom_base, std::nullopt};
  tracker.estimate(frame);
  EXPECT_LT(local(T_odom_base, tracker.locate(frame, {}, CSceneGraph())).norm(), 1e-12);
  EXPECT_TRUE(tracker.warnings().empty());
}

TEST(RobotTracker, LidarOdometryFollowsTheScansAndReplacesTheRecorded) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), true);
  const Pose3 T_last = Pose3::fromYawPitchRoll(0.4, -0.1, 0, 0.1, 0, 0);
  Pose3 T_odom_base;
  for (int i = 0; i <= 4; ++i) {
    SensorFrame frame = scanFrame(0.1 * i, interpolate(Pose3(), T_last, 0.25 * i));
    frame.odometry = OdometryState{Pose3::translation(100, 0, 0), std::nullopt};
    tracker.estimate(frame);
    T_odom_base = tracker.locate(frame, {}, CSceneGraph());
    if (i == 0) tracker.keyframeMade(frame);
  }
  constexpr double kTolerance = 0.02;
  EXPECT_LT(local(T_last, T_odom_base).norm(), kTolerance);
}

TEST(RobotTracker, LidarOdometryIsCarriedToTheStampsOfImagesAndDetections) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), false);
  SensorFrame frame;
  for (int i = 0; i <= 4; ++i) {
    frame = scanFrame(0.1 * i, Pose3::translation(0.1 * i, 0, 0));
    frame.images.resize(1);
    frame.images[0].stamp = at(0.1 * i + 0.02);
    test::see(frame, 7, Pose3());
    frame.detections[0].stamp = at(0.1 * i - 0.03);
    tracker.estimate(frame);
  }
  // 1 m/s along x, a little before and after the last scan at x = 0.4 m.
  constexpr double kTolerance_m = 0.01;
  ASSERT_TRUE(frame.images[0].odometry && frame.detections[0].odometry);
  EXPECT_NEAR(frame.images[0].odometry->T_odom_base.t.x(), 0.42, kTolerance_m);
  EXPECT_NEAR(frame.detections[0].odometry->T_odom_base.t.x(), 0.37, kTolerance_m);
}

TEST(RobotTracker, KnowsTheRecordedMotionSinceTheLastFrame) {
  RobotTracker tracker(withSource(OdometrySource::kRawlog), true);
  const Pose3 T_0_1 = Pose3::fromYawPitchRoll(0.1, 0.02, 0.0, 0.09, 0, 0);
  tracker.locate(frameAt(0.0, Pose3()), {}, CSceneGraph());
  EXPECT_FALSE(tracker.motionSinceLast());
  tracker.locate(frameAt(0.1, T_0_1), {}, CSceneGraph());
  ASSERT_TRUE(tracker.motionSinceLast() && tracker.sweepMotion());
  EXPECT_LT(local(T_0_1, tracker.motionSinceLast()->at(0.1)).norm(), 1e-9);
  EXPECT_LT(local(T_0_1, tracker.sweepMotion()->at(0.1)).norm(), 1e-9);
  EXPECT_FALSE(tracker.knowsSweepMotion());
  // Too long ago to tell how the robot moves.
  tracker.locate(frameAt(2.0, T_0_1), {}, CSceneGraph());
  EXPECT_FALSE(tracker.motionSinceLast());
}

TEST(RobotTracker, AStepThatNoRobotMakesIsNotTrusted) {
  const auto sigma_m = [](double last_step_m) {
    RobotTracker tracker(withSource(OdometrySource::kLidar), false);
    SensorFrame frame;
    for (int i = 0; i <= 3; ++i) {
      frame = scanFrame(0.1 * i, Pose3::translation(0.05 * i + (i == 3 ? last_step_m : 0), 0, 0));
      tracker.estimate(frame);
      tracker.locate(frame, {}, CSceneGraph());
      if (i == 2) tracker.keyframeMade(frame);
    }
    const Matrix6 covariance = tracker.covarianceSinceKeyframe(frame, CSceneGraph());
    return std::pair(std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1)));
  };
  // 5 m/s² are 5 cm in a tenth of a second.
  EXPECT_NEAR(sigma_m(0.4).first, 0.35, 0.03);
  EXPECT_LT(sigma_m(0.4).second, 0.03);
  EXPECT_LT(sigma_m(0.03).first, 0.01);
}

TEST(RobotTracker, MovingSweepsRegisteredAsTheyAreMakeTheOdometryLessCertain) {
  RobotOdometryParams params = withSource(OdometrySource::kLidar);
  params.lidar.method = "keyframe_gicp";
  const auto sigma_m = [&](bool timed) {
    RobotTracker tracker(params, false);
    SensorFrame frame;
    for (int i = 0; i <= 3; ++i) {
      frame = scanFrame(0.1 * i, Pose3::translation(0.1 * i, 0, 0));
      auto& times_s = frame.scan->cloud.time_offset_s;
      if (timed) times_s.assign(frame.scan->cloud.size(), 0.05F);
      if (timed) times_s.front() = 0.0F, times_s.back() = 0.1F;
      tracker.estimate(frame);
      tracker.locate(frame, {}, CSceneGraph());
      if (i == 0) tracker.keyframeMade(frame);
    }
    return std::sqrt(tracker.covarianceSinceKeyframe(frame, CSceneGraph())
                         .topLeftCorner<3, 3>()
                         .diagonal()
                         .minCoeff());
  };
  // Three sweeps of 0.1 m.
  const double expected_m = std::sqrt(3.0) * 0.1 * SweepDistortionParams().m_per_m;
  EXPECT_GT(sigma_m(true), 0.9 * expected_m);
  EXPECT_LT(sigma_m(false), 0.5 * expected_m);
}

TEST(RobotTracker, PredictsWhereTheNextScanIsTaken) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), true);
  for (int i = 0; i <= 4; ++i) {
    SensorFrame frame = scanFrame(0.1 * i, Pose3::translation(0.1 * i, 0, 0));
    tracker.estimate(frame);
  }
  SensorFrame next = scanFrame(0.5, Pose3::translation(0.5, 0, 0));
  next.odometry = OdometryState{Pose3::translation(100, 0, 0), std::nullopt};
  next.images.resize(1);
  next.images[0].stamp = at(0.52);
  tracker.predict(next);
  constexpr double kTolerance_m = 0.01;
  ASSERT_TRUE(next.odometry && next.images[0].odometry);
  EXPECT_NEAR(next.odometry->T_odom_base.t.x(), 0.5, kTolerance_m);
  EXPECT_NEAR(next.images[0].odometry->T_odom_base.t.x(), 0.52, kTolerance_m);
  tracker.estimate(next);
  EXPECT_NEAR(next.odometry->T_odom_base.t.x(), 0.5, kTolerance_m);
}

TEST(RobotTracker, IgnoredPointsTakeNoPart) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), false);
  SensorFrame frame = scanFrame(0, Pose3());
  PointIndices all(frame.scan->cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  tracker.estimate(frame, all);
  EXPECT_FALSE(frame.odometry);
  EXPECT_EQ(tracker.warnings().size(), 1U) << "too few points";
}

TEST(RobotTracker, LidarOdometryStartsLevel) {
  const Pose3 T_world_base = Pose3::fromYawPitchRoll(0, 0, 0, 0, 0.05, -0.04);
  RobotTracker tracker(withSource(OdometrySource::kLidar), false);
  SensorFrame frame = scanFrame(0, T_world_base);
  tracker.estimate(frame);
  const Pose3 T_odom_base = tracker.locate(frame, {}, CSceneGraph());
  constexpr double kTolerance_rad = 0.005;
  EXPECT_LT((T_odom_base.R.row(2) - T_world_base.R.row(2)).norm(), kTolerance_rad);
}

TEST(RobotTracker, AScanThatFitsNowhereIsCounted) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), false);
  SensorFrame good = scanFrame(0, Pose3()), empty = scanFrame(0.1, Pose3());
  empty.scan->cloud = PointCloud();
  tracker.estimate(good);
  tracker.estimate(empty);
  EXPECT_FALSE(empty.odometry);
  ASSERT_EQ(tracker.warnings().size(), 1u);
  EXPECT_EQ(tracker.warnings().begin()->first.rfind("LiDAR odometry: ", 0), 0u);
}

TEST(RobotTracker, WithoutOdometryTheMappedEntitiesTellWhereTheRobotIs) {
  RobotTracker tracker(withSource(OdometrySource::kAuto), false);
  const Pose3 T_map_box = Pose3::fromYawPitchRoll(5, 1, 0.3, 0.7, 0, 0);
  CSceneGraph graph = graphWithBox(T_map_box);
  graph.T_map_odom = Pose3::fromYawPitchRoll(0.2, 0, 0, 0.1, 0, 0);
  const Pose3 T_map_base = Pose3::fromYawPitchRoll(2, -1, 0, 0.4, 0, 0);
  SensorFrame frame;
  frame.stamp = at(1);
  const Pose3 T_odom_base =
      tracker.locate(frame, {observation(T_map_base.inverse() * T_map_box)}, graph);
  EXPECT_LT(local(T_map_base, graph.T_map_odom * T_odom_base).norm(), 1e-6);
  EXPECT_EQ(tracker.guessedFrames(), 0u);
}

TEST(RobotTracker, WithoutAnyKnowledgeTheRobotIsTakenToStandStill) {
  RobotTracker tracker(withSource(OdometrySource::kAuto), true);
  const Pose3 T_odom_base = Pose3::translation(3, 2, 1);
  tracker.locate(frameAt(0, T_odom_base), {}, CSceneGraph());
  SensorFrame blind;
  blind.stamp = at(1);
  EXPECT_LT(local(T_odom_base, tracker.locate(blind, {}, CSceneGraph())).norm(), 1e-12);
  EXPECT_EQ(tracker.warnings().at("frame without odometry"), 1u);
  EXPECT_EQ(tracker.guessedFrames(), 1u);
}

TEST(RobotTracker, LidarOdometryThatBeginsAnewIsCounted) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), false);
  SensorFrame frame = scanFrame(0, Pose3());
  tracker.estimate(frame);
  tracker.locate(frame, {}, CSceneGraph());
  EXPECT_EQ(tracker.guessedFrames(), 0u);
  // Another place altogether, far from the map.
  const int lost = withSource(OdometrySource::kLidar).lidar.local_map.max_lost_scans;
  for (int i = 1; i <= lost; ++i) {
    frame = scanFrame(0.1 * i, Pose3());
    for (auto& p : frame.scan->cloud.points) p += Eigen::Vector3f(60, 0, 0);
    tracker.estimate(frame);
    tracker.locate(frame, {}, CSceneGraph());
    EXPECT_EQ(frame.odometry.has_value(), i == lost) << i;
  }
  EXPECT_EQ(tracker.guessedFrames(), static_cast<std::uint64_t>(lost));
  EXPECT_EQ(tracker.warnings().at("LiDAR odometry: lost its way and began anew"), 1u);
}

/// Variance along x after driving so far along x in steps.
double varianceAfter(double distance_m) {
  RobotTracker tracker(withSource(OdometrySource::kRawlog), true);
  CSceneGraph graph;
  SensorFrame frame = frameAt(0, Pose3());
  tracker.locate(frame, {}, graph);
  tracker.keyframeMade(frame);
  for (double x = 0.1; x < distance_m + 0.05; x += 0.1) {
    frame = frameAt(x, Pose3::translation(x, 0, 0));
    tracker.locate(frame, {}, graph);
  }
  return tracker.covarianceSinceKeyframe(frame, graph)(0, 0);
}

TEST(RobotTracker, UncertaintyGrowsWithThePathSinceTheKeyframe) {
  const double jitter2 = std::pow(OdometryNoiseParams().jitter_m, 2);
  EXPECT_NEAR((varianceAfter(2.0) - jitter2) / (varianceAfter(1.0) - jitter2), 2.0, 1e-6);
}

TEST(RobotTracker, UncertaintyBeginsAnewWithEachKeyframe) {
  RobotTracker tracker(withSource(OdometrySource::kRawlog), true);
  CSceneGraph graph;
  SensorFrame frame = frameAt(0, Pose3());
  tracker.locate(frame, {}, graph);
  tracker.keyframeMade(frame);
  frame = frameAt(1, Pose3::translation(2, 0, 0));
  tracker.locate(frame, {}, graph);
  const double driven = tracker.covarianceSinceKeyframe(frame, graph)(0, 0);
  tracker.keyframeMade(frame);
  EXPECT_LT(tracker.covarianceSinceKeyframe(frame, graph)(0, 0), 0.5 * driven);
}

TEST(RobotTracker, LidarUncertaintyIsPositiveDefiniteAndLarge_WhenAScanFailed) {
  RobotTracker tracker(withSource(OdometrySource::kLidar), false);
  CSceneGraph graph;
  SensorFrame frame = scanFrame(0, Pose3());
  tracker.estimate(frame);
  tracker.locate(frame, {}, graph);
  tracker.keyframeMade(frame);
  frame = scanFrame(0.1, Pose3::translation(0.1, 0, 0));
  tracker.estimate(frame);
  tracker.locate(frame, {}, graph);
  const Matrix6 good = tracker.covarianceSinceKeyframe(frame, graph);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(good).eigenvalues().minCoeff(), 0.0);

  SensorFrame failed = scanFrame(0.2, Pose3::translation(0.2, 0, 0));
  failed.scan->cloud = PointCloud();
  tracker.estimate(failed);
  tracker.locate(failed, {}, graph);
  EXPECT_GT(tracker.covarianceSinceKeyframe(failed, graph)(0, 0), 100.0 * good(0, 0));
}

}  // namespace
}  // namespace dynemo
