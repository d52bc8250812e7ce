// The back-end against an independent solver on graphs with every kind of edge.
#include <gtest/gtest.h>

#include <set>

#include "ceres_reference.h"
#include "dynemo/backend/optimizer.h"
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

TEST_P(MixedGraph, HoldsEveryKindOfEdge) {
  const CSceneGraph graph = generateGraph({.seed = GetParam()}, 75);
  std::set<std::string> kinds;
  for (const auto& edge : graph.edgeSlots()) kinds.insert(edge->kind());
  for (const EdgeType& type : edgeTypes()) EXPECT_TRUE(kinds.contains(type.kind)) << type.kind;
}

TEST_P(MixedGraph, QuadraticCost) { expectSameMinimum(generateGraph({.seed = GetParam()}, 75)); }

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
