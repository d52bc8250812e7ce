#include "dynemo/backend/optimizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "dynemo/core/config.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"
#include "graph_states.h"

namespace dynemo::test {
namespace {

/// Residuals a thousandth of a micrometre of 0.1 m standard deviation.
constexpr double kZeroCost = 1e-15;

/// Everything at every call.
SolverParams batch() { return {.method = SolverParams::Method::kBatch}; }

/// Numbers of everything but the clock.
std::vector<double> figuresOf(const OptimizationReport& r) {
  return {static_cast<double>(r.stop), static_cast<double>(r.iterations),
          static_cast<double>(r.factorizations), r.cost_before, r.cost_after};
}

/// A square driven exactly, from a start that is wrong by `error`.
CSceneGraph exactSquare(double error, bool prior = true) {
  CSceneGraph graph;
  GraphDelta delta;
  Pose3 truth;
  const Pose3 step = Pose3::fromYawPitchRoll(2, 0.1, 0, M_PI / 2, 0, 0);
  const auto connect = [&](std::shared_ptr<CEdgeBase> edge, std::vector<NodeId> nodes) {
    edge->id = {delta.edges.size()};
    edge->nodes = std::move(nodes);
    edge->setInformation(100.0 * MatrixX::Identity(6, 6));
    delta.edges.push_back(edge);
  };
  for (std::size_t i = 0; i < 4; ++i) {
    auto node = std::make_shared<CNodeKeyframe>();
    node->id = {i};
    node->T_map_node = truth.retract(Vector6::Constant(i == 0 ? 0.0 : error * std::pow(-1.0, i)));
    delta.nodes.push_back(node);
    truth = truth * step;
  }
  if (prior) connect(std::make_shared<CEdgePosePrior>(), {{0}});
  for (std::size_t i = 0; i < 4; ++i) {
    auto edge = std::make_shared<CEdgeOdometry>();
    edge->T_1_2 = i < 3 ? step : (step * step * step).inverse();
    connect(edge, {{i}, {(i + 1) % 4}});
  }
  graph.apply(delta);
  return graph;
}

TEST(Optimizer, EmptyGraphIsNothingToDo) {
  CSceneGraph graph;
  const OptimizationReport report = Optimizer({}).optimize(graph);
  EXPECT_EQ(report.stop, StopReason::kNothingToDo);
  EXPECT_TRUE(report.usable());
  EXPECT_EQ(report.cost_after, 0.0);
}

TEST(Optimizer, ReachesZeroWhenTheMeasurementsAgree) {
  CSceneGraph graph = exactSquare(0.3);
  const OptimizationReport report = Optimizer({}).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_GT(report.cost_before, 1.0);
  EXPECT_LT(report.cost_after, kZeroCost);
  const Pose3 step = Pose3::fromYawPitchRoll(2, 0.1, 0, M_PI / 2, 0, 0);
  EXPECT_LT(local(step, graph.keyframes()[1]->T_map_node).norm(), 1e-8);
}

TEST(Optimizer, StartAtTheMinimumStaysThere) {
  CSceneGraph graph = exactSquare(0.0);
  const auto before = statesOf(graph);
  const OptimizationReport report = Optimizer({}).optimize(graph);
  EXPECT_TRUE(report.usable());
  const auto after = statesOf(graph);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-9);
}

TEST(Optimizer, WithoutAGaugeTheDampingHoldsIt) {
  CSceneGraph graph = exactSquare(0.3, /*prior=*/false);
  const Vector3 middle_before =
      graph.keyframes()[0]->T_map_node.t + graph.keyframes()[2]->T_map_node.t;
  const OptimizationReport report = Optimizer({}).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_LT(report.cost_after, kZeroCost);
  const Vector3 middle = graph.keyframes()[0]->T_map_node.t + graph.keyframes()[2]->T_map_node.t;
  EXPECT_LT((middle - middle_before).norm(), 2.0) << "the map did not run away";
}

TEST(Optimizer, FewFactorizationsAreEnoughFromAWarmStart) {
  GeneratedWorld world({.seed = 4});
  CSceneGraph graph;
  Optimizer optimizer(batch());
  int factorizations = 0, repeated = 0;
  for (int k = 0; k < 130; ++k) {
    graph.apply(world.nextKeyframe(graph));
    const OptimizationReport report = optimizer.optimize(graph);
    ASSERT_TRUE(report.usable()) << report.message;
    if (k < 30) continue;
    factorizations += report.factorizations;
    ++repeated;
  }
  EXPECT_LE(factorizations, 2 * repeated)
      << "more would mean that each minimum is confirmed by another one";
  CSceneGraph again = graph;
  SolverParams tight;
  tight.min_relative_decrease = 1e-12;
  const double cost = graph.totalCost();
  EXPECT_NEAR(Optimizer(tight).optimize(again).cost_after, cost, 1e-6 * cost)
      << "and it is the optimum";
}

TEST(Optimizer, AnsweredQuestionsCostNothing) {
  CSceneGraph graph = generateGraph({.seed = 2}, 60);
  Optimizer optimizer(batch());
  ASSERT_TRUE(optimizer.optimize(graph).usable());
  const OptimizationReport again = optimizer.optimize(graph);
  EXPECT_EQ(again.ordering_ms, 0.0) << "the structure is the same";
  EXPECT_EQ(again.symbolic_ms, 0.0);
  EXPECT_LE(again.factorizations, 1);
  EXPECT_NEAR(again.cost_after, again.cost_before, 1e-6 * again.cost_before);
}

TEST(Optimizer, FollowsTheGraphsChanges) {
  GeneratedWorld world({.seed = 11});
  CSceneGraph graph;
  Optimizer kept(batch());
  for (int k = 0; k < 40; ++k) {
    graph.apply(world.nextKeyframe(graph));
    if (k == 20) {
      GraphDelta removal;
      removal.removed_edges = {graph.edgesOf(graph.keyframes()[5]->id).back()};
      graph.apply(removal);
    }
    if (k % 9 == 4) {
      const auto& node = graph.keyframes()[static_cast<std::size_t>(k / 2)];
      node->T_map_node = node->T_map_node.retract(Vector6::Constant(0.02));
    }
    const double cost = graph.totalCost();
    const auto start = statesOf(graph);
    const OptimizationReport report = kept.optimize(graph);
    ASSERT_TRUE(report.usable());
    EXPECT_NEAR(report.cost_before, cost, 1e-9 * cost);
    // As one who sees the graph for the first time.
    const auto states = statesOf(graph);
    restoreStates(graph, start);
    ASSERT_TRUE(Optimizer(batch()).optimize(graph).usable());
    const auto fresh = statesOf(graph);
    for (std::size_t i = 0; i < states.size(); ++i) ASSERT_NEAR(states[i], fresh[i], 1e-6) << k;
    restoreStates(graph, states);
  }
  SolverParams tight;
  tight.min_relative_decrease = 1e-12;
  const double cost = graph.totalCost();
  EXPECT_NEAR(Optimizer(tight).optimize(graph).cost_after, cost, 1e-5 * cost);
}

TEST(Optimizer, SameInputSameBits) {
  for (const bool outliers : {false, true}) {
    const WorldParams params{.seed = 12, .outliers = outliers};
    CSceneGraph a = generateGraph(params, 350), b = generateGraph(params, 350);
    const OptimizationReport ra = Optimizer({}).optimize(a), rb = Optimizer({}).optimize(b);
    EXPECT_EQ(figuresOf(ra), figuresOf(rb));
    EXPECT_EQ(statesOf(a), statesOf(b));
  }
}

TEST(Optimizer, LonelyNodesAreLeftAlone) {
  CSceneGraph graph = exactSquare(0.1);
  GraphDelta delta;
  auto lonely = std::make_shared<CNodeKeyframe>();
  lonely->id = graph.nextNodeId();
  lonely->T_map_node = Pose3::translation(9, 9, 9);
  delta.nodes.push_back(lonely);
  graph.apply(delta);
  const OptimizationReport report = Optimizer({}).optimize(graph);
  EXPECT_TRUE(report.usable());
  EXPECT_EQ(report.nodes, 4u);
  EXPECT_EQ(lonely->T_map_node.t, Vector3(9, 9, 9));
}

TEST(Optimizer, ANodeSeenInOneDirectionOnlyDoesNotSpoilTheRest) {
  CSceneGraph graph = exactSquare(0.2);
  GraphDelta delta;
  auto floor = std::make_shared<CNodeFloor>();
  auto entity = std::make_shared<CNodeEntity>();
  floor->id = graph.nextNodeId();
  entity->id = {floor->id.value + 1};
  entity->T_map_node = Pose3::fromYawPitchRoll(3, 4, 1.0, 0.3, 0.2, 0.1);
  delta.nodes = {floor, entity};
  auto height = std::make_shared<CEdgeFloorEntity>();
  height->id = graph.nextEdgeId();
  height->nodes = {floor->id, entity->id};
  height->offset_m = -0.5;
  height->setInformation(MatrixX::Identity(1, 1));
  delta.edges = {height};
  graph.apply(delta);
  const OptimizationReport report = Optimizer({}).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_LT(report.cost_after, 1e-12);
  EXPECT_LT((entity->T_map_node.t.head<2>() - Vector2(3, 4)).norm(), 0.5)
      << "nothing moves it sideways";
}

TEST(Optimizer, AFactorRejectedByItsKernelDoesNotStopIt) {
  CSceneGraph graph = exactSquare(0.05);
  GraphDelta delta;
  auto node = std::make_shared<CNodeKeyframe>();
  node->id = graph.nextNodeId();
  node->T_map_node = Pose3::translation(1, 2, 3);
  delta.nodes = {node};
  auto wrong = std::make_shared<CEdgeLoopClosure>();
  wrong->id = graph.nextEdgeId();
  wrong->nodes = {{0}, node->id};
  wrong->T_1_2 = Pose3::translation(500, 0, 0);
  wrong->setInformation(MatrixX::Identity(6, 6));
  wrong->kernel = {KernelType::kTukey, 3.0};  // weight exactly zero
  delta.edges = {wrong};
  graph.apply(delta);
  const OptimizationReport report = Optimizer({}).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_NEAR(report.cost_after, 0.5 * 9.0 / 3.0, 1e-9) << "what the kernel charges for an outlier";
}

TEST(Optimizer, EstimatesThatAreNotFiniteAreNamedAndKept) {
  CSceneGraph graph = exactSquare(0.1);
  graph.keyframes()[2]->T_map_node.t.x() = std::nan("");
  const Pose3 before = graph.keyframes()[1]->T_map_node;
  const OptimizationReport report = Optimizer({}).optimize(graph);
  EXPECT_EQ(report.stop, StopReason::kNumericalFailure);
  EXPECT_FALSE(report.usable());
  EXPECT_NE(report.message.find("odometry edge"), std::string::npos) << report.message;
  EXPECT_NE(report.message.find('2'), std::string::npos) << report.message;
  EXPECT_EQ(graph.keyframes()[1]->T_map_node.t, before.t);
  EXPECT_EQ(graph.keyframes()[1]->T_map_node.R, before.R);
}

TEST(Optimizer, OverflowingCostsAreAFailureNotAHang) {
  CSceneGraph graph = exactSquare(0.1);
  graph.keyframes()[2]->T_map_node.t.x() = 1e200;
  const OptimizationReport report = Optimizer({}).optimize(graph);
  EXPECT_FALSE(report.usable());
  EXPECT_FALSE(report.message.empty());
  EXPECT_EQ(graph.keyframes()[2]->T_map_node.t.x(), 1e200);
}

TEST(Optimizer, IterationsAreLimited) {
  SolverParams params;
  params.max_iterations = 1;
  CSceneGraph graph = generateGraph({.seed = 3}, 80);
  const OptimizationReport report = Optimizer(params).optimize(graph);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_EQ(report.stop, StopReason::kMaxIterations);
  EXPECT_LT(report.cost_after, report.cost_before);
}

TEST(Optimizer, NeverRaisesTheCost) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    CSceneGraph graph = generateGraph({.seed = seed, .outliers = true}, 30);
    // A start far away, where a full step overshoots.
    std::mt19937_64 rng(seed);
    for (const auto& keyframe : graph.keyframes())
      keyframe->T_map_node = keyframe->T_map_node * randomPose(rng);
    const double before = graph.totalCost();
    const OptimizationReport report = Optimizer({}).optimize(graph);
    ASSERT_TRUE(report.usable()) << report.message;
    EXPECT_NEAR(report.cost_before, before, 1e-12 * before);
    EXPECT_LT(report.cost_after, before);
    EXPECT_NEAR(graph.totalCost(), report.cost_after, 1e-9 * report.cost_after);
  }
}

TEST(Optimizer, ReportAddsUp) {
  CSceneGraph graph = generateGraph({.seed = 3}, 80);
  const OptimizationReport r = Optimizer({}).optimize(graph);
  EXPECT_EQ(r.nodes, graph.nodeCount());
  EXPECT_EQ(r.edges, graph.edgeCount());
  std::size_t tangent_size = 0;
  for (const auto& node : graph.nodeSlots())
    tangent_size += static_cast<std::size_t>(node->tangentSize());
  EXPECT_EQ(r.tangent_size, tangent_size);
  for (const double ms : {r.ordering_ms, r.symbolic_ms, r.linearize_ms, r.numeric_ms, r.solve_ms})
    EXPECT_GT(ms, 0.0);
  EXPECT_GE(r.total_ms, r.ordering_ms + r.symbolic_ms + r.linearize_ms + r.numeric_ms + r.solve_ms);
}

TEST(Optimizer, CanBeMoved) {
  CSceneGraph graph = generateGraph({.seed = 3}, 30);
  Optimizer first({});
  ASSERT_TRUE(first.optimize(graph).usable());
  Optimizer second = std::move(first);
  EXPECT_TRUE(second.optimize(graph).usable());
}

TEST(SolverParams, LoadAndCheckTheirRanges) {
  SolverParams params;
  ConfigLoader loader;
  loader.addText(
      "{method: batch, max_iterations: 7, min_relative_decrease: 1e-4, min_step: 0, "
      "initial_lambda: 0.5}",
      "text");
  load(loader, params);
  EXPECT_EQ(params.max_iterations, 7);
  EXPECT_EQ(params.initial_lambda, 0.5);
  EXPECT_EQ(params.method, SolverParams::Method::kBatch);
  ConfigLoader wrong;
  wrong.addText("{max_iterations: 0, initial_lambda: -1}", "text");
  EXPECT_THROW(load(wrong, params), ConfigError);
}

TEST(StopReason, HasDistinctNames) {
  std::set<std::string> names;
  for (const auto reason :
       {StopReason::kNothingToDo, StopReason::kConverged, StopReason::kSmallStep,
        StopReason::kMaxIterations, StopReason::kNoDecrease, StopReason::kNumericalFailure}) {
    names.insert(stopReasonName(reason));
  }
  EXPECT_EQ(names.size(), 6u);
}

}  // namespace
}  // namespace dynemo::test
