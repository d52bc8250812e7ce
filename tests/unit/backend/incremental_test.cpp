// One step per change against the batch solver from the same start.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"
#include "graph_states.h"

namespace dynemo::test {
namespace {

constexpr double kRelativeCost = 1e-3;
/// Largest difference of a position or a rotation entry to the minimum's.
constexpr double kState = 0.05;

SolverParams batch() { return {.method = SolverParams::Method::kBatch}; }

double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Compares with the minimum that the batch solver reaches, and puts the estimates back.
void expectNearTheMinimum(CSceneGraph& graph, const OptimizationReport& report) {
  ASSERT_TRUE(report.usable()) << report.message;
  const double cost = graph.totalCost();
  EXPECT_NEAR(report.cost_after, cost, 1e-6 * cost + 1e-9);
  const auto states = statesOf(graph);
  Optimizer reference(batch());
  const OptimizationReport best = reference.optimize(graph);
  ASSERT_TRUE(best.usable()) << best.message;
  EXPECT_LT(cost, best.cost_after * (1.0 + kRelativeCost) + 1e-9);
  EXPECT_LT(largestDifference(states, statesOf(graph)), kState);
  restoreStates(graph, states);
}

class Incremental : public ::testing::TestWithParam<std::tuple<std::uint64_t, bool>> {
 protected:
  WorldParams params() const {
    return {.seed = std::get<0>(GetParam()),
            .keyframes_per_lap = 24,
            .loop_every = 7,
            .outliers = std::get<1>(GetParam())};
  }
};

TEST_P(Incremental, FollowsTheMinimumOfAGrowingGraph) {
  GeneratedWorld world(params());
  CSceneGraph graph;
  Optimizer optimizer({});
  for (int k = 0; k < 130; ++k) {
    graph.apply(world.nextKeyframe(graph));
    const OptimizationReport report = optimizer.optimize(graph);
    ASSERT_TRUE(report.usable()) << report.message;
    if (k % 13 == 12) expectNearTheMinimum(graph, report);
  }
}

TEST_P(Incremental, FollowsEdgesThatComeAndGo) {
  GeneratedWorld world(params());
  std::mt19937_64 rng(std::get<0>(GetParam()));
  CSceneGraph graph;
  Optimizer optimizer({});
  for (int k = 0; k < 90; ++k) {
    GraphDelta delta = world.nextKeyframe(graph);
    // Anything but the odometry and the priors, which hold the map together.
    const auto count = graph.nextEdgeId().value;
    for (int i = 0; count > 40 && i < 3; ++i) {
      const EdgeId edge{rng() % count};
      const auto& slot = graph.edgeSlots()[edge.value];
      if (!slot || dynamic_cast<const CEdgeOdometry*>(slot.get()) || slot->nodes.size() < 2)
        continue;
      if (std::count(delta.removed_edges.begin(), delta.removed_edges.end(), edge) > 0) continue;
      // A node keeps its detection, which alone fixes all of it.
      if (dynamic_cast<const CEdgeKeyframeEntity*>(slot.get())) continue;
      delta.removed_edges.push_back(edge);
    }
    graph.apply(delta);
    const OptimizationReport report = optimizer.optimize(graph);
    ASSERT_TRUE(report.usable()) << report.message;
    if (k % 15 == 14) expectNearTheMinimum(graph, report);
  }
}

TEST_P(Incremental, FollowsEstimatesThatAreChangedByOthers) {
  GeneratedWorld world(params());
  CSceneGraph graph;
  Optimizer optimizer({});
  std::mt19937_64 rng(std::get<0>(GetParam()));
  for (int k = 0; k < 60; ++k) {
    graph.apply(world.nextKeyframe(graph));
    if (k % 20 == 10) {
      for (int i = 0; i < 5; ++i) {
        const auto& keyframe = graph.keyframes()[rng() % graph.keyframes().size()];
        keyframe->T_map_node = keyframe->T_map_node.retract(Vector6::Constant(0.1));
      }
    }
    const OptimizationReport report = optimizer.optimize(graph);
    if (k % 10 == 0) expectNearTheMinimum(graph, report);
  }
}

TEST_P(Incremental, SameInputSameBytes) {
  const auto run = [&] {
    GeneratedWorld world(params());
    CSceneGraph graph;
    Optimizer optimizer({});
    for (int k = 0; k < 60; ++k) {
      graph.apply(world.nextKeyframe(graph));
      optimizer.optimize(graph);
    }
    return statesOf(graph);
  };
  EXPECT_EQ(run(), run());
}

INSTANTIATE_TEST_SUITE_P(Worlds, Incremental,
                         ::testing::Combine(::testing::Values(1, 2, 3, 108), ::testing::Bool()));

/// Steps and last states of a life in which somebody asks for a covariance before each one.
std::pair<int, std::vector<double>> stepsOfALife(bool asks) {
  GeneratedWorld world({.seed = 9});
  CSceneGraph graph;
  Optimizer optimizer({});
  int steps = 0;
  for (int k = 0; k < 80; ++k) {
    graph.apply(world.nextKeyframe(graph));
    const std::vector<NodeId> newest = {graph.keyframes().back()->id};
    if (asks && k > 0) {
      EXPECT_TRUE(optimizer.marginalCovariance(graph, newest).has_value());
    }
    steps += optimizer.optimize(graph).iterations;
  }
  return {steps, statesOf(graph)};
}

TEST(IncrementalSolver, CovariancesBeforeAStepDoNotSpoilIt) {
  const auto [steps, states] = stepsOfALife(false);
  const auto [steps_asked, states_asked] = stepsOfALife(true);
  EXPECT_LE(steps_asked, steps + steps / 20);
  EXPECT_LT(largestDifference(states, states_asked), 1e-3);
}

TEST(IncrementalSolver, WhereNothingIsToBeGainedNothingIsSolvedInBatch) {
  GeneratedWorld world({.seed = 10});
  CSceneGraph graph;
  Optimizer optimizer({});
  int factorizations = 0;
  for (int k = 0; k < 150; ++k) {
    graph.apply(world.nextKeyframe(graph));
    optimizer.optimize(graph);
    // Some nodes are linearised anew; that what is neglected raises the cost a little is no
    // failure.
    for (int i = 0; i < 2; ++i) factorizations += optimizer.optimize(graph).factorizations;
  }
  EXPECT_LE(factorizations, 72);
}

/// A map in the middle of its life.
class MidLife : public ::testing::Test {
 protected:
  MidLife() {
    for (int k = 0; k < 40; ++k) grow();
  }
  OptimizationReport grow() {
    graph_.apply(world_.nextKeyframe(graph_));
    return optimizer_.optimize(graph_);
  }
  GeneratedWorld world_{WorldParams{.seed = 9}};
  CSceneGraph graph_;
  Optimizer optimizer_{SolverParams{}};
};

TEST_F(MidLife, AStepTouchesAFractionOfTheGraph) {
  const OptimizationReport report = grow();
  EXPECT_EQ(report.factorizations, report.iterations);
  EXPECT_LE(report.iterations, 3);
  EXPECT_EQ(report.nodes, graph_.nodeCount());
  EXPECT_EQ(report.edges, graph_.edgeCount());
}

TEST_F(MidLife, NothingNewChangesNothing) {
  optimizer_.optimize(graph_);
  const auto before = statesOf(graph_);
  const OptimizationReport report = optimizer_.optimize(graph_);
  ASSERT_TRUE(report.usable());
  EXPECT_LT(largestDifference(before, statesOf(graph_)), 1e-3);
}

TEST_F(MidLife, ANodeThatLosesItsEdgesStaysAndComesBack) {
  GraphDelta delta;
  const NodeId lost = graph_.keyframes().back()->id;
  const std::vector<EdgeId> edges = graph_.edgesOf(lost);
  std::vector<CEdgeBase::Ptr> held;
  for (const EdgeId e : edges) held.push_back(graph_.edgeSlots()[e.value]);
  delta.removed_edges = edges;
  graph_.apply(delta);
  const Pose3 T_before = graph_.keyframes().back()->T_map_node;
  // The entities that only it saw float now; the solver says so or holds them.
  optimizer_.optimize(graph_);
  EXPECT_EQ(local(T_before, graph_.keyframes().back()->T_map_node).norm(), 0.0);

  GraphDelta back;
  for (const auto& edge : held) {
    auto copy = std::dynamic_pointer_cast<CEdgeBase>(edge->duplicateGetSmartPtr());
    copy->id = {graph_.nextEdgeId().value + back.edges.size()};
    back.edges.push_back(copy);
  }
  graph_.apply(back);
  optimizer_.optimize(graph_);
  expectNearTheMinimum(graph_, optimizer_.optimize(graph_));
}

TEST_F(MidLife, AnotherGraphIsAnotherProblem) {
  CSceneGraph other = generateGraph({.seed = 10}, 35);
  const OptimizationReport first = optimizer_.optimize(other);
  expectNearTheMinimum(other, first);
  expectNearTheMinimum(graph_, optimizer_.optimize(graph_));
}

TEST_F(MidLife, AStateThatIsNotANumberIsReportedAndSurvived) {
  const auto keyframe = graph_.keyframes()[20];
  const Pose3 T = keyframe->T_map_node;
  keyframe->T_map_node.t.x() = std::nan("");
  const OptimizationReport report = optimizer_.optimize(graph_);
  EXPECT_FALSE(report.usable());
  EXPECT_NE(report.message.find("not finite"), std::string::npos) << report.message;
  keyframe->T_map_node = T;
  expectNearTheMinimum(graph_, optimizer_.optimize(graph_));
}

TEST(IncrementalWithoutGauge, FallsBackToTheDampedSolver) {
  GeneratedWorld world({.seed = 4, .pose_prior = false, .floor_prior = false});
  CSceneGraph graph;
  Optimizer optimizer({});
  for (int k = 0; k < 40; ++k) {
    graph.apply(world.nextKeyframe(graph));
    const OptimizationReport report = optimizer.optimize(graph);
    ASSERT_TRUE(report.usable()) << report.message;
    EXPECT_LE(report.cost_after, report.cost_before * (1.0 + 1e-9));
  }
}

TEST(IncrementalAfterALoad, StartsWithABatchSolution) {
  CSceneGraph graph = generateGraph({.seed = 6}, 120);
  Optimizer optimizer({});
  const OptimizationReport report = optimizer.optimize(graph);
  CSceneGraph again = generateGraph({.seed = 6}, 120);
  EXPECT_EQ(report.cost_after, Optimizer(batch()).optimize(again).cost_after);
}

TEST(OptimizeFully, ReachesTheMinimumWhateverTheMethod) {
  GeneratedWorld world({.seed = 12, .outliers = true});
  CSceneGraph graph;
  Optimizer optimizer({});
  for (int k = 0; k < 50; ++k) {
    graph.apply(world.nextKeyframe(graph));
    optimizer.optimize(graph);
  }
  const double cost = optimizer.optimizeFully(graph).cost_after;
  const OptimizationReport more = Optimizer(batch()).optimize(graph);
  EXPECT_NEAR(more.cost_after, cost, 1e-5 * cost);
}

}  // namespace
}  // namespace dynemo::test
