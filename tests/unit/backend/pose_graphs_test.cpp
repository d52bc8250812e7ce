// Published pose graphs and their minima.
#include <gtest/gtest.h>

#include <mrpt/io/CFileGZInputStream.h>

#include <Eigen/Dense>
#include <fstream>
#include <sstream>

#include "ceres_reference.h"
#include "dynemo/backend/chordal_initialization.h"
#include "dynemo/backend/g2o_io.h"
#include "dynemo/backend/optimizer.h"
#include "g2o_edge.h"
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
    auto g2o = std::make_shared<backend::G2oEdge>();
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

TEST(PublishedIndefinite, CubicleIsRefusedOrRepaired) {
  const auto file = largePoseGraph("cubicle.g2o");
  if (!file) GTEST_SKIP() << "DYNEMO_POSE_GRAPHS does not name a folder with cubicle.g2o";
  EXPECT_THROW(readG2o(*file), DataError);
  G2oReadOptions options;
  options.residual = G2oReadOptions::Residual::kG2o;
  options.indefinite = G2oReadOptions::Indefinite::kRepair;
  auto contents = readG2o(*file, options);
  EXPECT_EQ(contents.repaired_edges, 5021u);
  const double before = contents.graph.totalCost();
  const OptimizationReport report = Optimizer({}).optimize(contents.graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_LT(report.cost_after, before);
}

/// The file with Ω = diag(2τ I, 16κ I), τ and κ from the diagonal blocks of what it has: the form
/// in which a minimum of this graph was published.
std::string isotropic(std::istream& in) {
  std::ostringstream out;
  out.precision(17);
  for (std::string text; std::getline(in, text);) {
    if (text.rfind("EDGE_SE3:QUAT", 0) != 0) {
      out << text << '\n';
      continue;
    }
    std::istringstream line(text);
    std::string word;
    for (int i = 0; i < 10; ++i) {
      line >> word;
      out << word << ' ';
    }
    Matrix6 omega;
    for (int r = 0; r < 6; ++r)
      for (int c = r; c < 6; ++c) {
        line >> omega(r, c);
        omega(c, r) = omega(r, c);
      }
    const double tau = 3.0 / omega.topLeftCorner<3, 3>().inverse().trace();
    const double kappa = 1.5 / omega.bottomRightCorner<3, 3>().inverse().trace();
    for (int r = 0; r < 6; ++r)
      for (int c = r; c < 6; ++c) out << (r != c ? 0.0 : r < 3 ? 2.0 * tau : 16.0 * kappa) << ' ';
    out << '\n';
  }
  return out.str();
}

TEST(PublishedIsotropic, CubicleReachesItsMinimumFromTheChordalStart) {
  const auto file = largePoseGraph("cubicle.g2o");
  if (!file) GTEST_SKIP() << "DYNEMO_POSE_GRAPHS does not name a folder with cubicle.g2o";
  std::ifstream in(*file);
  std::istringstream text(isotropic(in));
  G2oReadOptions options;
  options.residual = G2oReadOptions::Residual::kG2o;
  CSceneGraph graph = readG2o(text, "isotropic cubicle", options).graph;
  ASSERT_TRUE(initializeChordal(graph));
  const OptimizationReport report = Optimizer(tight()).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_NEAR(report.cost_after, 717.126, 1e-3);
}

TEST(PublishedNoisy, TheNoisySphereReachesItsMinimumFromTheChordalStart) {
  const auto file = largePoseGraph("sphere_bignoise_vertex3.g2o.gz");
  if (!file) GTEST_SKIP() << "DYNEMO_POSE_GRAPHS does not name a folder with the noisy sphere";
  mrpt::io::CFileGZInputStream in;
  ASSERT_TRUE(in.open(file->string()));
  std::string text;
  char buffer[65536];
  while (const std::size_t n = in.Read(buffer, sizeof(buffer))) text.append(buffer, n);
  std::istringstream stream(text);
  G2oReadOptions options;
  options.residual = G2oReadOptions::Residual::kG2o;
  CSceneGraph graph = readG2o(stream, "noisy sphere", options).graph;
  ASSERT_TRUE(initializeChordal(graph));
  EXPECT_NEAR(graph.totalCost(), 394036, 1.0);
  const OptimizationReport report = Optimizer(tight()).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
  EXPECT_NEAR(report.cost_after, 371931.4, 0.5);
}

}  // namespace
}  // namespace dynemo::test
