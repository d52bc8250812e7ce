// Reads graph.graph and graph.g2o back with MRPT itself.
#include <gtest/gtest.h>
#include <mrpt/graphs/CNetworkOfPoses.h>

#include <numbers>
#include <sstream>

#include "dynemo/core/mrpt_conversions.h"
#include "keyframe_pose_graph.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

constexpr double kTextTolerance = 1e-12;

mrpt::graphs::CNetworkOfPoses3DInf readBack(const SmallRun& run,
                                            const std::string& format = "graph") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "graph.graph";
  std::ofstream(file, std::ios::binary) << exported(format, run.result());
  mrpt::graphs::CNetworkOfPoses3DInf network;
  network.loadFromTextFile(file.string());
  return network;
}

using PoseEdges =
    std::map<std::pair<std::uint64_t, std::uint64_t>, mrpt::poses::CPose3DPDFGaussianInf>;

/// The EDGE3 lines, in TORO's order x y z roll pitch yaw. A reader of the test's own, since that of
/// MRPT 2.5 drops the correlations among the angles.
PoseEdges parseEdges(const std::string& text) {
  constexpr int kMrptIndex[] = {0, 1, 2, 5, 4, 3};
  PoseEdges edges;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream in(line);
    std::string tag;
    std::uint64_t from = 0, to = 0;
    if (!(in >> tag) || tag != "EDGE3") continue;
    double x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0;
    in >> from >> to >> x >> y >> z >> roll >> pitch >> yaw;
    auto& edge = edges[{from, to}];
    edge.mean = mrpt::poses::CPose3D(x, y, z, yaw, pitch, roll);
    for (int r = 0; r < 6; ++r)
      for (int c = r; c < 6; ++c) {
        in >> edge.cov_inv(kMrptIndex[r], kMrptIndex[c]);
        edge.cov_inv(kMrptIndex[c], kMrptIndex[r]) = edge.cov_inv(kMrptIndex[r], kMrptIndex[c]);
      }
    EXPECT_FALSE(in.fail()) << line;
  }
  return edges;
}

/// eᵀ Ω e with e the difference of x, y, z, yaw, pitch, roll.
double chiSquared(const mrpt::poses::CPose3DPDFGaussianInf& edge, const Pose3& T) {
  const mrpt::poses::CPose3D other = toMrpt(T);
  Vector6 e;
  for (unsigned i = 0; i < 6; ++i) e[i] = other[i] - edge.mean[i];
  for (int i = 3; i < 6; ++i) e[i] = std::remainder(e[i], 2.0 * std::numbers::pi);
  return e.dot(edge.cov_inv.asEigen() * e);
}

TEST(MrptGraph, KeepsTheKeyframesAndTheRoot) {
  const SmallRun run = smallRun();
  const auto network = readBack(run);
  ASSERT_EQ(network.nodeCount(), 3u);
  EXPECT_EQ(network.root, 0u);
  for (const auto& keyframe : run.graph.keyframes()) {
    const Pose3 T = fromMrpt(network.nodes.at(keyframe->id.value));
    EXPECT_LT(local(keyframe->T_map_base(), T).norm(), kTextTolerance);
  }
}

TEST(MrptGraph, FusesParallelEdgesInsteadOfLosingThem) {
  const SmallRun run = smallRun();
  EXPECT_EQ(readBack(run).edgeCount(), 2u);
}

TEST(MrptGraph, InformationMeansTheSameInItsAngles) {
  constexpr double kStep = 1e-6, kRelativeTolerance = 1e-4;
  const SmallRun run = smallRun();
  const auto edges = parseEdges(exported("graph", run.result()));
  for (const auto& [pair, expected] : keyframePoseGraph(run.graph)) {
    const auto& edge = edges.at({pair.first.value, pair.second.value});
    EXPECT_LT(local(expected.T_1_2, fromMrpt(edge.mean)).norm(), kTextTolerance);
    for (int axis = 0; axis < 6; ++axis) {
      Vector6 step = Vector6::Constant(0.3 * kStep);
      step[axis] = kStep;
      const double expected_cost = step.dot(expected.information * step);
      EXPECT_NEAR(chiSquared(edge, expected.T_1_2.retract(step)), expected_cost,
                  kRelativeTolerance * expected_cost);
    }
  }
}

TEST(MrptGraph, ReadsG2oToo) {
  const SmallRun run = smallRun();
  const auto network = readBack(run, "g2o");
  ASSERT_EQ(network.nodes.size(), 6u);
  for (const auto& [id, T] : network.nodes) {
    const Pose3& expected = run.graph.getNode<CNodePose>({id}).T_map_node;
    EXPECT_LT(local(expected, fromMrpt(T)).norm(), 1e-9) << id;
  }
  // Of the seven edges, MRPT keeps one of the two between keyframes 0 and 1.
  EXPECT_EQ(network.edgeCount(), 6u);
}

}  // namespace
}  // namespace dynemo::test
