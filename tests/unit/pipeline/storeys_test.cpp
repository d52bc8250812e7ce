// A building with two storeys and stairs, ray-cast, driven through the whole pipeline.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/seen_plane.h"
#include "frames.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

constexpr double kStorey_m = 3.0, kBase_m = 0.5, kWall_m = 0.06;
constexpr double kPi = 3.14159265358979323846;

/// 14 × 8 m, two storeys of 3 m; a flight of 15 steps from (3, −3) to (3, 1.5) through an opening.
test::World building() {
  test::World world;
  auto& b = world.boxes;
  b.push_back(test::Box::between({-7, -4, -0.2}, {7, 4, 0}));
  b.push_back(test::Box::between({-7, -4, 2 * kStorey_m}, {7, 4, 2 * kStorey_m + 0.2}));
  // The upper floor, around the opening x 2 … 4, y −3.5 … 1.5.
  b.push_back(test::Box::between({-7, -4, kStorey_m - 0.2}, {2, 4, kStorey_m}));
  b.push_back(test::Box::between({4, -4, kStorey_m - 0.2}, {7, 4, kStorey_m}));
  b.push_back(test::Box::between({2, 1.5, kStorey_m - 0.2}, {4, 4, kStorey_m}));
  b.push_back(test::Box::between({2, -4, kStorey_m - 0.2}, {4, -3.5, kStorey_m}));
  const double top = 2 * kStorey_m;
  b.push_back(test::Box::between({-7 - kWall_m, -4, -0.2}, {-7, 4, top}));
  b.push_back(test::Box::between({7, -4, -0.2}, {7 + kWall_m, 4, top}));
  b.push_back(test::Box::between({-7, -4 - kWall_m, -0.2}, {7, -4, top}));
  b.push_back(test::Box::between({-7, 4, -0.2}, {7, 4 + kWall_m, top}));
  // An inner wall of 12 cm on each storey, not at the same place.
  b.push_back(test::Box::between({-1.06, -4, 0}, {-0.94, 1, kStorey_m - 0.2}));
  b.push_back(test::Box::between({-3.06, -1, kStorey_m}, {-2.94, 4, top}));
  for (int step = 0; step < 15; ++step) {
    const double y = -3.0 + 0.3 * step;
    b.push_back(test::Box::between({2, y, 0}, {4, y + 0.3, 0.2 * (step + 1)}));
  }
  return world;
}

/// Up the stairs and down again; z is that of the ground.
std::vector<Vector3> waypoints() {
  return {{-4, -2, 0},   {-4, 2.5, 0}, {0, 2.5, 0},  {1, -3.4, 0},  {3, -3.4, 0},
          {3, 1.5, 3},   {3, 2.7, 3},  {-1, 2.7, 3}, {-1, -2.5, 3}, {-5, -2.5, 3},
          {-1, -2.5, 3}, {0, 2.7, 3},  {3, 2.7, 3},  {3, 1.5, 3},   {3, -3.4, 0},
          {1, -3.4, 0},  {0, 2.5, 0},  {-4, 2.5, 0}, {-4, -2, 0}};
}

std::vector<Pose3> path(double step_m) {
  std::vector<Pose3> poses;
  const auto corners = waypoints();
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vector3 d = corners[i + 1] - corners[i];
    const double yaw = std::atan2(d.y(), d.x());
    const int steps = std::max(1, static_cast<int>(std::lround(d.norm() / step_m)));
    for (int s = 0; s < steps; ++s) {
      const Vector3 p = corners[i] + d * (static_cast<double>(s) / steps);
      poses.push_back(Pose3::fromYawPitchRoll(p.x(), p.y(), p.z() + kBase_m, yaw, 0, 0));
    }
  }
  return poses;
}

struct Tour {
  std::unique_ptr<SlamPipeline> pipeline;
  Pose3 T_world_map;
  std::vector<Pose3> truth;
  const CSceneGraph& graph() const { return pipeline->graph(); }
};

/// Odometry with a scale error, that sinks by `sink_per_m` of its path: 10 cm over the whole of it.
Tour drive(double sink_per_m) {
  static const EntityModels models;
  DynemoParams params = test::externalOnly();
  params.odometry.noise.source = OdometryNoiseSource::kModel;
  Tour run;
  run.pipeline = std::make_unique<SlamPipeline>(params, models, true);
  run.truth = path(0.6);
  run.T_world_map = run.truth.front();
  const test::World world = building();
  test::LidarModel lidar;
  lidar.rows = 24;
  lidar.columns = 360;
  lidar.vertical_fov_rad = 1.0;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(11);
  Pose3 T_odom_base;
  for (std::size_t i = 0; i < run.truth.size(); ++i) {
    const Pose3& T_world_base = run.truth[i];
    if (i > 0) {
      Pose3 step = run.truth[i - 1].inverse() * T_world_base;
      step.t *= 1.005;
      step.t.z() -= sink_per_m * step.t.norm();
      T_odom_base = T_odom_base * step;
    }
    SensorFrame frame = test::frameAt(0.5 * static_cast<double>(i), T_odom_base);
    frame.index = i;
    frame.scan = test::sweep(
        world, lidar, [&](double) { return T_world_base; }, 0.0, random);
    frame.scan->stamp = frame.stamp;
    // One box on each storey.
    for (const auto& [id, p] : {std::pair(1, Vector3(-5, 0, 0.3)), {2, Vector3(-1.5, 1, 3.3)}}) {
      const Pose3 T_base_box = T_world_base.inverse() * Pose3::translation(p);
      if (T_base_box.t.norm() < 4.0 && std::abs(T_base_box.t.z()) < 1.0)
        test::see(frame, id, T_base_box);
    }
    test::process(*run.pipeline, std::move(frame));
  }
  run.pipeline->finish();
  return run;
}

class Storeys : public ::testing::Test {
 protected:
  static const Tour& tour() {
    static const Tour once = drive(0.002);
    return once;
  }
  /// Height of the true ground under a keyframe, over that of the lower storey.
  static double trueGround(const CNodeKeyframe& keyframe) {
    return tour().truth[keyframe.frame_index].t.z() - kBase_m;
  }
};

TEST_F(Storeys, AreTwoAndFoundAgain) {
  const CSceneGraph& graph = tour().graph();
  ASSERT_EQ(graph.floors().size(), 2u);
  EXPECT_NEAR(graph.floors()[0]->level_m, -kBase_m, 0.01);
  EXPECT_NEAR(graph.floors()[1]->level_m, kStorey_m - kBase_m, 0.03);
}

TEST_F(Storeys, EveryKeyframeIsOnItsOwnAndNoneOnTheStairsBetween) {
  const CSceneGraph& graph = tour().graph();
  std::vector<NodeId> in_order;
  double last_ground = 0.0;
  for (const auto& keyframe : graph.keyframes()) {
    const double ground = trueGround(*keyframe);
    // A storey begins where the robot does not climb any more.
    const bool arrived = std::abs(ground - last_ground) < 0.01;
    last_ground = ground;
    if (arrived && (ground < 0.01 || ground > kStorey_m - 0.01)) {
      ASSERT_TRUE(keyframe->floor) << keyframe->frame_index;
      EXPECT_EQ(*keyframe->floor, graph.floors()[ground < 1.0 ? 0 : 1]->id)
          << keyframe->frame_index;
    } else if (ground > 0.7 && ground < kStorey_m - 0.7) {
      EXPECT_FALSE(keyframe->floor) << keyframe->frame_index;
    }
    if (keyframe->floor && (in_order.empty() || in_order.back() != *keyframe->floor))
      in_order.push_back(*keyframe->floor);
  }
  const NodeId lower = graph.floors()[0]->id, upper = graph.floors()[1]->id;
  EXPECT_EQ(in_order, (std::vector<NodeId>{lower, upper, lower}));
}

TEST_F(Storeys, TheGroundTakesTheDriftOutOfTheHeights) {
  for (const auto& keyframe : tour().graph().keyframes()) {
    const Pose3 T_world_base = tour().T_world_map * keyframe->T_map_base();
    EXPECT_NEAR(T_world_base.t.z(), tour().truth[keyframe->frame_index].t.z(), 0.03)
        << keyframe->frame_index;
  }
}

TEST_F(Storeys, EntitiesAndWallsBelongToTheirs) {
  const CSceneGraph& graph = tour().graph();
  for (const auto& [entity, track] : graph.tracks()) {
    for (const auto& node : track) {
      const auto floor = graph.getNode<CNodeKeyframe>(node->keyframe).floor;
      ASSERT_TRUE(floor);
      EXPECT_EQ(*floor, graph.floors()[entity.value == 1 ? 0 : 1]->id);
      int heights = 0;
      for (const EdgeId id : graph.edgesOf(node->id)) {
        const auto* edge = dynamic_cast<const CEdgeFloorEntity*>(graph.edgeSlots()[id.value].get());
        if (!edge) continue;
        ++heights;
        EXPECT_EQ(edge->nodes[0], *floor);
      }
      EXPECT_EQ(heights, 1);
    }
  }
  // The inner walls, of which each storey has its own.
  for (const auto& plane : graph.planes()) {
    const Plane3 world = tour().T_world_map * plane->plane_map;
    if (std::abs(world.normal.x()) < 0.99) continue;
    const double x = -world.d_m / world.normal.x();
    if (std::abs(x + 1.0) < 0.2) {
      EXPECT_EQ(floorOf(graph, *plane), graph.floors()[0]->id);
    }
    if (std::abs(x + 3.0) < 0.2) {
      EXPECT_EQ(floorOf(graph, *plane), graph.floors()[1]->id);
    }
  }
}

TEST_F(Storeys, WallsAreMappedOnceWithBothFaces) {
  const CSceneGraph& graph = tour().graph();
  const auto count = [&](const Vector3& normal, double at) {
    int n = 0;
    for (const auto& plane : graph.planes()) {
      const Plane3 world = tour().T_world_map * plane->plane_map;
      n += world.normal.dot(normal) > 0.999 &&
           std::abs(-world.d_m - normal.dot(at * normal.cwiseAbs())) < 0.05;
    }
    return n;
  };
  EXPECT_EQ(count(Vector3::UnitX(), -7), 1);
  EXPECT_EQ(count(-Vector3::UnitX(), 7), 1);
  EXPECT_EQ(count(Vector3::UnitY(), -4), 1);
  EXPECT_EQ(count(-Vector3::UnitY(), 4), 1);
  EXPECT_EQ(count(-Vector3::UnitX(), -1.06), 1);
  EXPECT_EQ(count(Vector3::UnitX(), -0.94), 1);
}

TEST_F(Storeys, WhitenedResidualsAreOfTheOrderOfOne) {
  const CSceneGraph& graph = tour().graph();
  double chi2 = 0.0;
  int n = 0;
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge || !dynamic_cast<const CEdgePlaneMeasurement*>(edge.get())) continue;
    chi2 += 2.0 * graph.edgeCost(*edge);
    n += 3;
  }
  ASSERT_GT(n, 300);
  EXPECT_LT(chi2 / n, 1.5);
}

}  // namespace
}  // namespace dynemo
