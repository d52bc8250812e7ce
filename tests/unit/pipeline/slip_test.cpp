// Odometry that slips once and reports nothing of it, in a room with a box.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dynemo/graph/edge_relative_pose.h"
#include "frames.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

constexpr int kFrames = 24, kSlipAt = 12;
const Vector3 kSlip_m(0.0, 0.12, 0.0);

test::World room() {
  test::World world;
  world.boxes = {
      test::Box::between({-5, -4, -0.2}, {5, 4, 0}), test::Box::between({-5.1, -4, 0}, {-5, 4, 3}),
      test::Box::between({5, -4, 0}, {5.1, 4, 3}), test::Box::between({-5, -4.1, 0}, {5, -4, 3}),
      test::Box::between({-5, 4, 0}, {5, 4.1, 3})};
  return world;
}

Pose3 truth(int i) { return Pose3::translation(-3.0 + 0.25 * i, 0.0, 0.5); }

std::unique_ptr<SlamPipeline> drive(double max_slip_m) {
  static const EntityModels models;
  DynemoParams params = test::externalOnly();
  params.odometry.noise.source = OdometryNoiseSource::kModel;
  params.odometry.noise.translation_per_sqrt_m = 0.002;
  params.odometry.noise.jitter_m = 0.001;
  params.mapping.planes.association.max_slip_m = max_slip_m;
  auto pipeline = std::make_unique<SlamPipeline>(params, models, true);
  const test::World world = room();
  test::LidarModel lidar;
  lidar.rows = 24;
  lidar.columns = 360;
  lidar.vertical_fov_rad = 1.0;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(3);
  for (int i = 0; i < kFrames; ++i) {
    Pose3 T_odom_base = truth(0).inverse() * truth(i);
    if (i >= kSlipAt) T_odom_base.t += kSlip_m;
    SensorFrame frame = test::frameAt(0.5 * i, T_odom_base);
    frame.index = static_cast<std::uint64_t>(i);
    frame.scan = test::sweep(
        world, lidar, [&](double) { return truth(i); }, 0.0, random);
    frame.scan->stamp = frame.stamp;
    test::see(frame, 1, truth(i).inverse() * Pose3::translation(4, 1, 0.3));
    test::process(*pipeline, std::move(frame));
  }
  pipeline->finish();
  return pipeline;
}

std::size_t moves(const CSceneGraph& graph) {
  const auto& track = graph.tracks().at({1});
  return static_cast<std::size_t>(
      std::count_if(track.begin(), track.end(), [](const auto& node) { return node->moved; }));
}

/// Largest standard deviation of an odometry edge across the robot's way.
double widest_m(const CSceneGraph& graph) {
  double widest = 0.0;
  for (const auto& edge : graph.edgeSlots()) {
    if (!dynamic_cast<const CEdgeOdometry*>(edge.get())) continue;
    const Matrix6 covariance = edge->information().inverse();
    widest = std::max(widest, std::sqrt(covariance(1, 1)));
  }
  return widest;
}

double error_m(const SlamPipeline& pipeline) {
  const Pose3 expected = truth(0).inverse() * truth(kFrames - 1);
  return (pipeline.frames().back().T_map_base.t - expected.t).norm();
}

TEST(Slip, IsSeenByTheWallsAndNotTakenForMotion) {
  const auto pipeline = drive(0.15);
  EXPECT_EQ(pipeline->graph().planes().size(), 4u);
  EXPECT_EQ(moves(pipeline->graph()), 0u);
  EXPECT_LT(error_m(*pipeline), 0.02);
  EXPECT_NEAR(widest_m(pipeline->graph()), kSlip_m.y(), 0.03);
}

TEST(Slip, MakesASecondLayerWhereWallsAreNotAsked) {
  const auto pipeline = drive(0.0);
  EXPECT_GT(pipeline->graph().planes().size(), 4u);
  EXPECT_GT(moves(pipeline->graph()), 0u);
  EXPECT_GT(error_m(*pipeline), 0.05);
  EXPECT_LT(widest_m(pipeline->graph()), 0.02);
}

}  // namespace
}  // namespace dynemo
