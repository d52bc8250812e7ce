// What the removal of moved objects is worth: pairs of made-up scans in which objects were moved
// together, and pairs in which none was.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/loops/entity_aware_matcher.h"
#include "dynemo/matching/matcher_chain.h"
#include "loop_graph.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

constexpr int kPairs = 6;
constexpr double kNoKernel_m = 1e3;

/// Five objects of the size of cupboards, most of what is near the robot.
std::vector<test::Box> objects() {
  const auto box = [](double x, double y, double yaw) {
    return test::Box{Pose3::fromYawPitchRoll(x, y, 0.7, yaw, 0, 0), 0.5 * Vector3(1.2, 0.8, 1.4)};
  };
  return {box(-1.5, 1.0, 0.3), box(0.3, -2.5, -0.2), box(-2.2, -2.6, 0.8), box(-0.6, 2.6, 0.1),
          box(0.6, 0.2, 1.2)};
}

/// Points of the scan on the object.
PointIndices pointsOn(const Scan& scan, const Pose3& T_world_base, const test::Box& box) {
  const Pose3 T_box_lidar = box.T_world_box.inverse() * T_world_base * scan.T_base_lidar;
  PointIndices points;
  for (std::uint32_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3 p = T_box_lidar * scan.cloud.points[i].cast<double>();
    if (((p.cwiseAbs() - box.half_size_m).array() < 0.05).all()) points.push_back(i);
  }
  return points;
}

/// A keyframe with its scan and the objects it sees, appended to the graph.
void addKeyframe(CSceneGraph& graph, const test::World& room,
                 const std::vector<test::Box>& movables, const Pose3& T_world_base,
                 std::mt19937_64& random) {
  test::World world = room;
  world.boxes.insert(world.boxes.end(), movables.begin(), movables.end());
  test::LidarModel lidar;
  lidar.rows = 32;
  lidar.columns = 512;
  lidar.sweep_s = 0.0;
  auto scan = std::make_shared<const Scan>(test::sweep(
      world, lidar, [&](double) { return T_world_base; }, 0.0, random));

  auto keyframe = std::make_shared<CNodeKeyframe>();
  keyframe->id = graph.nextNodeId();
  keyframe->T_map_node = T_world_base;
  keyframe->scan = scan;
  GraphDelta delta;
  delta.nodes = {keyframe};
  for (std::size_t i = 0; i < movables.size(); ++i) {
    auto entity = std::make_shared<CNodeEntity>();
    entity->id = {graph.nextNodeId().value + delta.nodes.size()};
    entity->entity = {static_cast<std::int64_t>(i + 1)};
    entity->keyframe = keyframe->id;
    entity->T_map_node = movables[i].T_world_box;
    entity->fragment = pointsOn(*scan, T_world_base, movables[i]);
    auto edge = std::make_shared<CEdgeKeyframeEntity>();
    edge->id = {graph.nextEdgeId().value + delta.edges.size()};
    edge->nodes = {keyframe->id, entity->id};
    edge->T_1_2 = T_world_base.inverse() * movables[i].T_world_box;
    edge->setCovariance(isotropicCovariance(0.02, 0.03));
    delta.nodes.push_back(entity);
    delta.edges.push_back(edge);
  }
  graph.apply(delta);
}

LoopParams withPrefilter(const MatchingParams& matching, const std::string& method) {
  LoopParams params;
  params.matching = matching;
  params.prefilter.method = method;
  return params;
}

/// Median translation error of the match by prefilter.
std::map<std::string, double> medianErrors(bool moved, bool kernel) {
  MatchingParams matching;
  if (!kernel) {
    for (RegistrationParams* p : {&matching.annealed_gicp.coarse, &matching.annealed_gicp.fine})
      p->kernel_m = kNoKernel_m;
  }
  std::map<std::string, std::vector<double>> errors;
  for (int n = 0; n < kPairs; ++n) {
    std::mt19937_64 random(static_cast<std::uint64_t>(100 + n));
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    auto before = objects(), after = before;
    const double angle = 3.0 * uniform(random);
    const Pose3 move = Pose3::translation(0.35 * std::cos(angle), 0.35 * std::sin(angle), 0);
    if (moved) {
      for (test::Box& box : after) box.T_world_box = move * box.T_world_box;
    }
    const Pose3 T_world_a = Pose3::fromYawPitchRoll(-1.2, -0.8, 0.6, uniform(random), 0, 0);
    const Pose3 T_world_b = Pose3::fromYawPitchRoll(
        -1.2 + 0.8 * uniform(random), -0.8 + 0.5 * uniform(random), 0.6, uniform(random), 0, 0);
    CSceneGraph graph;
    addKeyframe(graph, test::furnishedRoom(), before, T_world_a, random);
    addKeyframe(graph, test::furnishedRoom(), after, T_world_b, random);

    LoopPair pair;
    pair.candidate = {0, 1, LoopOrigin::kDistance, 0, 0};
    pair.earlier = graph.keyframes()[0].get();
    pair.later = graph.keyframes()[1].get();
    const Pose3 truth = T_world_a.inverse() * T_world_b;
    Vector6 drift;
    for (int i = 0; i < 6; ++i) drift[i] = uniform(random) * (i < 2 ? 0.05 : 0.01);
    pair.predicted = {truth.retract(drift), isotropicCovariance(0.05, 0.01)};
    pair.shared = sharedEntities(graph, *pair.earlier, *pair.later);
    for (const std::string& method : entityPrefilters().names()) {
      EntityAwareMatcher matcher(withPrefilter(matching, method), makeScanMatcher(matching));
      const auto matched = matcher.match(graph, pair, pair.predicted);
      errors[method].push_back(matched.match ? (matched.match->T_target_source.t - truth.t).norm()
                                             : 1.0);
    }
  }
  std::map<std::string, double> medians;
  for (auto& [method, list] : errors) {
    std::nth_element(list.begin(), list.begin() + kPairs / 2, list.end());
    medians[method] = list[kPairs / 2];
  }
  std::cout << (moved ? "moved" : "static") << (kernel ? ", robust kernel" : ", no kernel") << ":";
  for (const auto& [method, error_m] : medians)
    std::cout << "  " << method << " " << 1000 * error_m << " mm";
  std::cout << '\n';
  return medians;
}

class MovedObjects : public testing::TestWithParam<bool> {};

TEST_P(MovedObjects, RemovingThemIsBetterByAQuarter) {
  auto error_m = medianErrors(true, GetParam());
  EXPECT_LE(error_m["motion"], 0.75 * error_m["none"]);
  EXPECT_LE(error_m["motion"], error_m["always"]);
}

TEST_P(MovedObjects, WhereNothingMovedNothingIsLost) {
  auto error_m = medianErrors(false, GetParam());
  EXPECT_LE(error_m["motion"], error_m["none"]);
}

INSTANTIATE_TEST_SUITE_P(RobustKernel, MovedObjects, testing::Bool(),
                         [](const auto& test) { return test.param ? "with" : "without"; });

}  // namespace
}  // namespace dynemo
