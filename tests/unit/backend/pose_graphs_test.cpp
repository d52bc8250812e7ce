// Published pose graphs and their minima.
#include <gtest/gtest.h>

#include "ceres_reference.h"
#include "dynemo/backend/chordal_initialization.h"
#include "dynemo/backend/g2o_io.h"
#include "dynemo/backend/optimizer.h"
#include "g2o_residual.h"
#include "pose_graph_files.h"

namespace dynemo::test {
namespace {

constexpr double kRelativeCost = 1e-6;

SolverParams tight() {
  SolverParams params;
  params.min_relative_decrease = 1e-10;
  return params;
}

/// The same graph with g2o's residual and information.
CSceneGraph withG2oResidual(const CSceneGraph& graph) {
  CSceneGraph copy;
  GraphDelta delta;
  for (const auto& keyframe : graph.keyframes())
    delta.nodes.push_back(std::make_shared<CNodeKeyframe>(*keyframe));
  const Vector6 s = (Vector6() << 1, 1, 1, 2, 2, 2).finished();
  for (const auto& edge : graph.edgeSlots()) {
    const auto& relative = dynamic_cast<const CEdgeRelativePose&>(*edge);
    auto g2o = std::make_shared<G2oEdge>();
    g2o->id = edge->id;
    g2o->nodes = edge->nodes;
    g2o->T_1_2 = relative.T_1_2;
    const Matrix6 information = s.asDiagonal() * Matrix6(edge->information()) * s.asDiagonal();
    g2o->setInformation(information);
    delta.edges.push_back(g2o);
  }
  copy.apply(delta);
  return copy;
}

struct Published {
  std::string file;
  bool copied_here;
  bool chordal;  ///< from the file's own guess every local solver ends in another minimum
  /// ½ Σ rᵀΩr with g2o's residual and with the SE(3) logarithm, at their minima.
  std::optional<double> cost_g2o;
  /// Half a unit of the last digit that was published.
  double rounding = 0.0;
};

void PrintTo(const Published& p, std::ostream* out) { *out << p.file; }

class PoseGraphs : public ::testing::TestWithParam<Published> {
 protected:
  void SetUp() override {
    const auto file =
        GetParam().copied_here
            ? std::optional(std::filesystem::path(DYNEMO_TEST_POSE_GRAPHS) / GetParam().file)
            : largePoseGraph(GetParam().file);
    if (!file) GTEST_SKIP() << "DYNEMO_POSE_GRAPHS does not name a folder with " << GetParam().file;
    graph_ = readG2o(*file).graph;
    if (GetParam().chordal) {
      ASSERT_TRUE(initializeChordal(graph_));
    }
  }
  CSceneGraph graph_;
};

TEST_P(PoseGraphs, ReachesThePublishedMinimum) {
  if (!GetParam().cost_g2o) GTEST_SKIP() << "no figure was published for " << GetParam().file;
  CSceneGraph graph = withG2oResidual(graph_);
  const OptimizationReport report = Optimizer(tight()).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_NEAR(report.cost_after, *GetParam().cost_g2o,
              kRelativeCost * *GetParam().cost_g2o + GetParam().rounding);
}

TEST_P(PoseGraphs, ReachesTheMinimumOfAnIndependentSolver) {
  const CeresResult reference = solveWithCeres(graph_, 1e-11);
  ASSERT_TRUE(reference.converged);
  const OptimizationReport report = Optimizer(tight()).optimize(graph_);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_NEAR(report.cost_before, reference.cost_before, 1e-9 * reference.cost_before);
  EXPECT_NEAR(report.cost_after, reference.cost_after, kRelativeCost * reference.cost_after);
}

TEST_P(PoseGraphs, DefaultParametersStopWithinTheirTolerance) {
  CSceneGraph tightly = graph_;  // shares its nodes: solved one after the other
  const OptimizationReport loose = Optimizer({}).optimize(graph_);
  ASSERT_TRUE(loose.usable()) << loose.message;
  const OptimizationReport report = Optimizer(tight()).optimize(tightly);
  EXPECT_NEAR(loose.cost_after, report.cost_after, 2e-6 * report.cost_after);
}

INSTANTIATE_TEST_SUITE_P(
    Published, PoseGraphs,
    ::testing::Values(Published{"tinyGrid3D.g2o", true, false, {}, 0.0},
                      Published{"smallGrid3D.g2o", true, false, 229.0769, 5e-5},
                      Published{"parking-garage.g2o", false, false, 0.619345, 5e-7},
                      Published{"sphere2500.g2o", false, false, 363.5748, 5e-5},
                      Published{"torus3D.g2o", false, true, 7287.373, 5e-4}),
    [](const auto& graph) {
      return graph.param.file.substr(0, graph.param.file.find_first_of("-."));
    });

}  // namespace
}  // namespace dynemo::test
