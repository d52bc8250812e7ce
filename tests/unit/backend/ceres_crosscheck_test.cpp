// The back-end against an independent solver on graphs with every kind of edge.
#include <gtest/gtest.h>

#include <set>

#include "ceres_reference.h"
#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_summary.h"
#include "dynemo/graph/types.h"
#include "generated_graph.h"

namespace dynemo::test {
namespace {

constexpr double kRelativeCost = 1e-6;

SolverParams tight() {
  SolverParams params;
  params.min_relative_decrease = 1e-10;
  params.max_iterations = 200;
  return params;
}

void expectSameMinimum(CSceneGraph graph) {
  const CeresResult reference = solveWithCeres(graph, 1e-12);
  ASSERT_TRUE(reference.converged);
  ASSERT_NEAR(graph.totalCost(), reference.cost_before, 1e-9 * reference.cost_before);
  const OptimizationReport report = Optimizer(tight()).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_NEAR(report.cost_after, reference.cost_after, kRelativeCost * reference.cost_after)
      << stopReasonName(report.stop) << " after " << report.iterations << " iterations";
  EXPECT_NEAR(graph.totalCost(), report.cost_after, 1e-12 * report.cost_after);
  EXPECT_LT(report.cost_after, 0.9 * report.cost_before);
}

class MixedGraph : public ::testing::TestWithParam<std::uint64_t> {};

/// A drive, and what takes the place of keyframes that have left one.
CSceneGraph everyKind(std::uint64_t seed) {
  CSceneGraph graph = generateGraph({.seed = seed}, 75);
  GraphDelta delta;
  auto summary = std::make_shared<CEdgeSummary>();
  summary->id = graph.nextEdgeId();
  summary->nodes = {graph.keyframes()[3]->id, graph.tracks().begin()->second.back()->id};
  const Pose3 T_1_2 = graph.keyframes()[3]->T_map_base().inverse() *
                      graph.tracks().begin()->second.back()->T_map_entity();
  summary->T_1_2 = T_1_2 * Pose3::translation(0.1, -0.05, 0.02);
  summary->setCovariance(isotropicCovariance(0.1, 0.05));
  delta.edges.push_back(summary);
  graph.apply(delta);
  return graph;
}

TEST_P(MixedGraph, HoldsEveryKindOfEdge) {
  const CSceneGraph graph = everyKind(GetParam());
  std::set<std::string> kinds;
  for (const auto& edge : graph.edgeSlots()) kinds.insert(edge->kind());
  for (const EdgeType& type : edgeTypes()) EXPECT_TRUE(kinds.contains(type.kind)) << type.kind;
}

TEST_P(MixedGraph, QuadraticCost) { expectSameMinimum(everyKind(GetParam())); }

TEST_P(MixedGraph, RobustKernelsAndOutliers) {
  expectSameMinimum(generateGraph({.seed = GetParam(), .outliers = true}, 75));
}

TEST_P(MixedGraph, FreeGauge) {
  expectSameMinimum(
      generateGraph({.seed = GetParam(), .pose_prior = false, .floor_prior = false}, 75));
}

TEST_P(MixedGraph, LargeEnoughForNestedDissection) {
  expectSameMinimum(generateGraph({.seed = GetParam()}, 300));
}

INSTANTIATE_TEST_SUITE_P(Seeds, MixedGraph, ::testing::Values(1, 2, 3));

}  // namespace
}  // namespace dynemo::test
