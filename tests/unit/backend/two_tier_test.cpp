// The window at once, the whole map later: deterministic, free of jumps, and in the end the
// minimum.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <atomic>
#include <cmath>
#include <thread>

#include "dynemo/backend/optimizer.h"
#include "generated_graph.h"
#include "graph_states.h"

namespace dynemo::test {
namespace {

constexpr int kKeyframes = 90;

SolverParams twoTiers() {
  SolverParams params;
  params.method = SolverParams::Method::kTwoTier;
  params.window_keyframes = 12;
  params.join_every = 5;
  return params;
}

struct Life {
  explicit Life(std::uint64_t seed, bool outliers = false)
      : world({.seed = seed, .keyframes_per_lap = 24, .loop_every = 7, .outliers = outliers}) {}
  OptimizationReport grow() {
    graph.apply(world.nextKeyframe(graph));
    return optimizer.optimize(graph);
  }
  GeneratedWorld world;
  CSceneGraph graph;
  Optimizer optimizer{twoTiers()};
};

TEST(TwoTier, IsTheSameWhateverTheThreadsDo) {
  const auto run = [](bool disturbed) {
    std::atomic<bool> stop{false};
    std::vector<std::thread> noise;
    for (int i = 0; disturbed && i < 3; ++i) {
      noise.emplace_back([&stop] {
        while (!stop) std::this_thread::yield();
      });
    }
    Life r(3);
    std::vector<double> all;
    for (int k = 0; k < kKeyframes; ++k) {
      if (disturbed && k % 11 == 0) std::this_thread::yield();
      r.grow();
      const auto states = statesOf(r.graph);
      all.insert(all.end(), states.begin(), states.end());
    }
    stop = true;
    for (auto& thread : noise) thread.join();
    return all;
  };
  EXPECT_EQ(run(false), run(true));
}

TEST(TwoTier, ReachesTheMinimumOnceTheWholeMapHasAnswered) {
  for (const bool outliers : {false, true}) {
    Life r(4, outliers);
    for (int k = 0; k < kKeyframes; ++k) ASSERT_TRUE(r.grow().usable());
    for (int i = 0; i < 6 * twoTiers().join_every; ++i) r.optimizer.optimize(r.graph);
    const double cost = r.graph.totalCost();
    SolverParams batch;
    batch.method = SolverParams::Method::kBatch;
    EXPECT_LT(cost, Optimizer(batch).optimize(r.graph).cost_after * 1.001);
  }
}

TEST(TwoTier, MergingDoesNotShakeTheRobotsSurroundings) {
  Life r(5);
  const auto newestStep = [&] {
    const auto& keyframes = r.graph.keyframes();
    return keyframes[keyframes.size() - 2]->T_map_node.inverse() * keyframes.back()->T_map_node;
  };
  for (int k = 0; k < kKeyframes; ++k) {
    r.graph.apply(r.world.nextKeyframe(r.graph));
    if (k == 0) {
      r.optimizer.optimize(r.graph);
      continue;
    }
    const Pose3 T_before = newestStep();
    r.optimizer.optimize(r.graph);
    // The new keyframe is where odometry (3 cm, 8 mrad) put it beside the one before it.
    EXPECT_LT(local(T_before, newestStep()).head<3>().norm(), 0.15) << "keyframe " << k;
  }
}

TEST(TwoTier, ReportsWhatTheWindowHolds) {
  Life r(6);
  OptimizationReport report;
  for (int k = 0; k < kKeyframes; ++k) report = r.grow();
  EXPECT_LT(report.nodes, r.graph.nodeCount() / 2);
  EXPECT_GT(report.nodes, 12u);
  EXPECT_LE(report.cost_after, report.cost_before);
}

TEST(TwoTier, CovariancesOfTheWindowAndOfTheRest) {
  Life r(7);
  for (int k = 0; k < kKeyframes; ++k) r.grow();
  const std::vector<NodeId> recent = {r.graph.keyframes().back()->id,
                                      r.graph.keyframes()[kKeyframes - 5]->id};
  const std::vector<NodeId> far = {r.graph.keyframes().back()->id, r.graph.keyframes()[2]->id};
  for (const auto& nodes : {recent, far}) {
    const auto joint = r.optimizer.marginalCovariance(r.graph, nodes);
    ASSERT_TRUE(joint) << joint.error();
    EXPECT_EQ(joint->rows(), 12);
    EXPECT_GT(joint->ldlt().vectorD().minCoeff(), 0.0);
  }
}

TEST(TwoTier, SurvivesStatesThatAreNotNumbers) {
  Life r(8);
  for (int k = 0; k < 30; ++k) r.grow();
  const auto keyframe = r.graph.keyframes().back();
  const Pose3 T = keyframe->T_map_node;
  keyframe->T_map_node.t.x() = std::nan("");
  EXPECT_FALSE(r.optimizer.optimize(r.graph).usable());
  keyframe->T_map_node = T;
  for (int k = 0; k < 12; ++k) EXPECT_TRUE(r.grow().usable());
}

}  // namespace
}  // namespace dynemo::test
