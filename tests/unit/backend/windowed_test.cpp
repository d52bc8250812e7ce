// The window at once, the whole map later: deterministic, true to a solution of everything, and in
// the end the minimum.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <atomic>
#include <cmath>
#include <thread>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"
#include "graph_states.h"

namespace dynemo::test {
namespace {

constexpr int kKeyframes = 150;

SolverParams windowed(bool second_thread = true) {
  SolverParams params;
  params.method = SolverParams::Method::kWindowed;
  params.window_keyframes = 12;
  params.second_thread = second_thread;
  return params;
}

struct Life {
  explicit Life(std::uint64_t seed, SolverParams params = windowed(), bool outliers = false)
      : world({.seed = seed, .keyframes_per_lap = 24, .loop_every = 7, .outliers = outliers}),
        optimizer(params) {}
  OptimizationReport grow() {
    graph.apply(world.nextKeyframe(graph));
    return optimizer.optimize(graph);
  }
  GeneratedWorld world;
  CSceneGraph graph;
  Optimizer optimizer;
};

std::vector<double> wholeLife(bool second_thread, bool disturbed) {
  std::atomic<bool> stop{false};
  std::vector<std::thread> noise;
  for (int i = 0; disturbed && i < 3; ++i) {
    noise.emplace_back([&stop] {
      while (!stop) std::this_thread::yield();
    });
  }
  Life r(3, windowed(second_thread));
  std::vector<double> all;
  for (int k = 0; k < kKeyframes; ++k) {
    r.grow();
    const auto states = statesOf(r.graph);
    all.insert(all.end(), states.begin(), states.end());
  }
  stop = true;
  for (auto& thread : noise) thread.join();
  return all;
}

TEST(Windowed, IsTheSameWithOneThreadAndWithTwo) {
  const auto alone = wholeLife(false, false);
  EXPECT_EQ(alone, wholeLife(true, false));
  EXPECT_EQ(alone, wholeLife(true, true));
}

/// How far the newest keyframe is from where a solution of everything has it, in standard
/// deviations.
double deviationOfNewest(Life& r, const Pose3& T_map_base) {
  const auto states = statesOf(r.graph);
  Optimizer whole({.method = SolverParams::Method::kBatch});
  EXPECT_TRUE(whole.optimizeFully(r.graph).usable());
  const CNodeKeyframe& newest = *r.graph.keyframes().back();
  const Vector6 e = local(newest.T_map_node, T_map_base);
  const std::vector<NodeId> node = {newest.id};
  const auto covariance = whole.marginalCovariance(r.graph, node);
  restoreStates(r.graph, states);
  EXPECT_TRUE(covariance) << covariance.error();
  return std::sqrt(e.dot(covariance->ldlt().solve(e)));
}

constexpr double kSmallDeviation = 0.5;

TEST(Windowed, TheNewestPosesAreThoseOfASolutionOfEverything) {
  Life r(4);
  int windows = 0;
  for (int k = 0; k < kKeyframes; ++k) {
    const OptimizationReport report = r.grow();
    ASSERT_TRUE(report.usable()) << report.message;
    windows += report.nodes < r.graph.nodeCount() ? 1 : 0;
    if (k % 4 != 3) continue;
    EXPECT_LT(deviationOfNewest(r, r.graph.keyframes().back()->T_map_node), kSmallDeviation)
        << "keyframe " << k;
  }
  EXPECT_GT(windows, 3 * kKeyframes / 4);
}

TEST(Windowed, MergingDoesNotShakeTheRobot) {
  Life r(5);
  const auto& keyframes = r.graph.keyframes();
  for (int k = 0; k < kKeyframes; ++k) {
    r.grow();
    if (k % 3 != 2) continue;
    // A call with nothing new, which may merge: the robot stays where the window put it.
    const Pose3 T_before = keyframes.back()->T_map_node;
    r.optimizer.optimize(r.graph);
    const Pose3 T_after = keyframes.back()->T_map_node;
    EXPECT_LT(deviationOfNewest(r, T_before), kSmallDeviation) << "keyframe " << k;
    EXPECT_LT(deviationOfNewest(r, T_after), kSmallDeviation) << "keyframe " << k;
  }
}

TEST(Windowed, TheRestOfTheMapFollowsBetweenMerges) {
  Life r(12);
  for (int k = 0; k < kKeyframes; ++k) {
    r.grow();
    if (k < 50 || k % 5 != 4) continue;
    const double cost = r.graph.totalCost();
    const auto states = statesOf(r.graph);
    EXPECT_LT(cost, Optimizer({}).optimizeFully(r.graph).cost_after * 1.001) << "keyframe " << k;
    restoreStates(r.graph, states);
  }
}

TEST(Windowed, ReachesTheMinimumOnceTheWholeMapHasAnswered) {
  for (const bool outliers : {false, true}) {
    Life r(6, windowed(), outliers);
    for (int k = 0; k < kKeyframes; ++k) ASSERT_TRUE(r.grow().usable());
    for (int i = 0; i < 4 * windowed().window_keyframes; ++i) r.optimizer.optimize(r.graph);
    const double cost = r.graph.totalCost();
    EXPECT_LT(cost, Optimizer({}).optimizeFully(r.graph).cost_after * 1.001);
  }
}

TEST(Windowed, FollowsEdgesThatGo) {
  Life r(7);
  for (int k = 0; k < kKeyframes; ++k) {
    GraphDelta delta = r.world.nextKeyframe(r.graph);
    if (k % 17 == 16) {
      for (const auto& edge : r.graph.edgeSlots()) {
        if (!dynamic_cast<const CEdgeLoopClosure*>(edge.get())) continue;
        delta.removed_edges.push_back(edge->id);
        break;
      }
    }
    r.graph.apply(delta);
    ASSERT_TRUE(r.optimizer.optimize(r.graph).usable());
  }
  for (int i = 0; i < 4 * windowed().window_keyframes; ++i) r.optimizer.optimize(r.graph);
  const double cost = r.graph.totalCost();
  EXPECT_LT(cost, Optimizer({}).optimizeFully(r.graph).cost_after * 1.001);
}

TEST(Windowed, CovariancesAreThoseOfTheWholeGraph) {
  Life r(8);
  for (int k = 0; k < kKeyframes - 2; ++k) r.grow();
  const auto& keyframes = r.graph.keyframes();
  // New, new, touched or of the map only.
  const std::vector<NodeId> nodes = {keyframes.back()->id, keyframes[keyframes.size() - 2]->id,
                                     r.graph.planes().front()->id, keyframes[2]->id,
                                     keyframes[40]->id};
  const auto joint = r.optimizer.marginalCovariance(r.graph, nodes);
  ASSERT_TRUE(joint) << joint.error();
  SolverParams batch;
  batch.method = SolverParams::Method::kBatch;
  const auto expected = Optimizer(batch).marginalCovariance(r.graph, nodes);
  ASSERT_TRUE(expected) << expected.error();
  EXPECT_LT((*joint - *expected).norm(), 0.02 * expected->norm());
}

TEST(Windowed, CovariancesOutlastEdgesThatComeAndGo) {
  Life r(8);
  for (int k = 0; k < 60; ++k) r.grow();
  const std::vector<NodeId> node = {r.graph.keyframes()[30]->id};
  // An answer of the whole map, after which the window is empty.
  GraphDelta removal;
  removal.removed_edges = {r.graph.edgesOf(r.graph.keyframes()[20]->id).back()};
  r.graph.apply(removal);
  r.optimizer.optimize(r.graph);
  const auto before = r.optimizer.marginalCovariance(r.graph, node);
  ASSERT_TRUE(before) << before.error();
  auto closure = std::make_shared<CEdgeLoopClosure>();
  closure->id = r.graph.nextEdgeId();
  closure->nodes = {r.graph.keyframes()[10]->id, node[0]};
  closure->T_1_2 =
      r.graph.keyframes()[10]->T_map_node.inverse() * r.graph.keyframes()[30]->T_map_node;
  closure->setInformation(1e4 * MatrixX::Identity(6, 6));
  GraphDelta delta;
  delta.edges = {closure};
  r.graph.apply(delta);
  const auto tied = r.optimizer.marginalCovariance(r.graph, node);
  ASSERT_TRUE(tied) << tied.error();
  EXPECT_LT(tied->trace(), before->trace());
  GraphDelta undo;
  undo.removed_edges = {closure->id};
  r.graph.apply(undo);
  const auto after = r.optimizer.marginalCovariance(r.graph, node);
  ASSERT_TRUE(after) << after.error();
  EXPECT_NEAR(after->trace(), before->trace(), 1e-6 * before->trace());
}

TEST(Windowed, SurvivesStatesThatAreNotNumbers) {
  Life r(9);
  for (int k = 0; k < 60; ++k) r.grow();
  const auto keyframe = r.graph.keyframes().back();
  const Pose3 T = keyframe->T_map_node;
  keyframe->T_map_node.t.x() = std::nan("");
  EXPECT_FALSE(r.optimizer.optimize(r.graph).usable());
  keyframe->T_map_node = T;
  for (int k = 0; k < 12; ++k) EXPECT_TRUE(r.grow().usable());
}

TEST(Windowed, NoticesAnotherGraph) {
  Life a(10), b(11);
  for (int k = 0; k < 60; ++k) a.grow();
  for (int k = 0; k < 60; ++k) b.graph.apply(b.world.nextKeyframe(b.graph));
  for (int i = 0; i < 3 * windowed().window_keyframes; ++i)
    ASSERT_TRUE(a.optimizer.optimize(b.graph).usable());
  const double cost = b.graph.totalCost();
  EXPECT_LT(cost, Optimizer({}).optimizeFully(b.graph).cost_after * 1.001);
}

}  // namespace
}  // namespace dynemo::test
