// Reads graph.g2o with a parser of its own and evaluates g2o's error as its documentation defines
// it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <sstream>

#include "dynemo/graph/edge_relative_pose.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct G2oEdge {
  int from = 0, to = 0;
  Eigen::Isometry3d measurement;
  Matrix6d information;
};

struct G2oGraph {
  std::map<int, Eigen::Isometry3d> vertices;
  std::vector<G2oEdge> edges;
  std::vector<int> fixed;
};

Eigen::Isometry3d readPose(std::istream& in) {
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  in >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = q.toRotationMatrix();
  T.translation() = t;
  return T;
}

G2oGraph parse(const std::string& text) {
  G2oGraph graph;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream in(line);
    std::string tag;
    in >> tag;
    if (tag.starts_with('#')) continue;
    if (tag == "VERTEX_SE3:QUAT") {
      int id = -1;
      in >> id;
      EXPECT_TRUE(graph.vertices.emplace(id, readPose(in)).second) << line;
    } else if (tag == "EDGE_SE3:QUAT") {
      G2oEdge e;
      in >> e.from >> e.to;
      e.measurement = readPose(in);
      for (int r = 0; r < 6; ++r)
        for (int c = r; c < 6; ++c) {
          in >> e.information(r, c);
          e.information(c, r) = e.information(r, c);
        }
      graph.edges.push_back(e);
    } else if (tag == "FIX") {
      in >> graph.fixed.emplace_back();
    } else {
      ADD_FAILURE() << "unknown tag: " << line;
    }
    EXPECT_FALSE(in.fail()) << line;
  }
  return graph;
}

double chiSquared(const G2oGraph& graph, const G2oEdge& edge) {
  const Eigen::Isometry3d delta = edge.measurement.inverse() *
                                  graph.vertices.at(edge.from).inverse() *
                                  graph.vertices.at(edge.to);
  Eigen::Quaterniond q(delta.linear());
  if (q.w() < 0) q.coeffs() *= -1;
  Eigen::Matrix<double, 6, 1> e;
  e << delta.translation(), q.vec();
  return e.dot(edge.information * e);
}

std::vector<const CEdgeRelativePose*> relativePoses(const CSceneGraph& graph) {
  std::vector<const CEdgeRelativePose*> list;
  for (const auto& slot : graph.edgeSlots()) {
    if (const auto* edge = dynamic_cast<const CEdgeRelativePose*>(slot.get())) list.push_back(edge);
  }
  return list;
}

TEST(G2o, KeepsPosesExactly) {
  constexpr double kRotationTolerance = 1e-14;
  const SmallRun run = smallRun();
  const G2oGraph read = parse(exported("g2o", run.result()));
  EXPECT_EQ(read.fixed, std::vector<int>{0});
  ASSERT_EQ(read.vertices.size(), 6u);
  for (const auto& [id, T] : read.vertices) {
    const Pose3& expected =
        run.graph.getNode<CNodePose>({static_cast<std::uint64_t>(id)}).T_map_node;
    EXPECT_EQ(expected.t, T.translation());
    EXPECT_LT((expected.R - T.linear()).norm(), kRotationTolerance);
  }
}

TEST(G2o, EveryEdgeCostsWhatItCostsInTheGraph) {
  // sin(r/2) against r/2 at the residuals of the run (|r| < 0.01) differs by less than this.
  constexpr double kRelativeTolerance = 1e-4;
  const SmallRun run = smallRun();
  const G2oGraph read = parse(exported("g2o", run.result()));
  const auto edges = relativePoses(run.graph);
  ASSERT_EQ(read.edges.size(), edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].from, static_cast<int>(edges[i]->nodes[0].value));
    EXPECT_EQ(read.edges[i].to, static_cast<int>(edges[i]->nodes[1].value));
    const double expected = 2.0 * run.graph.edgeCost(*edges[i]);
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(chiSquared(read, read.edges[i]), expected, kRelativeTolerance * expected);
  }
}

TEST(G2o, SaysWhatItLeavesOut) {
  const SmallRun run = smallRun();
  const std::string text = exported("g2o", run.result());
  EXPECT_NE(text.find("# left out: 1 floor_entity edges\n"), std::string::npos);
  EXPECT_NE(text.find("# left out: 1 pose_prior edges\n"), std::string::npos);
  EXPECT_NE(text.find("# 6 entity 7 stamp 1700000030.523456789\n"), std::string::npos);
}

}  // namespace
}  // namespace dynemo::test
