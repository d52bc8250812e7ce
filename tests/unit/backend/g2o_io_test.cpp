#include "dynemo/backend/g2o_io.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"

namespace dynemo::test {
namespace {

const std::string kIdentityPose = " 0 0 0 0 0 0 1";
const std::string kVertices =
    "VERTEX_SE3:QUAT 0" + kIdentityPose + "\nVERTEX_SE3:QUAT 5 1 2 3 0 0 0.6 0.8\n";
const std::string kInformation = " 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 8 0 12";

G2oContents read(const std::string& text, G2oReadOptions options = {}) {
  std::istringstream in(text);
  return readG2o(in, "graph.g2o", options);
}

std::string complaint(const std::string& text, G2oReadOptions options = {}) {
  try {
    read(text, options);
  } catch (const DataError& e) {
    return e.what();
  }
  return "";
}

#define EXPECT_CONTAINS(text, part) \
  EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

TEST(G2oReader, ReadsVerticesEdgesAndFixedPoses) {
  const auto contents = read("# comment\n\n" + kVertices + "EDGE_SE3:QUAT 0 5 1 0 0 0 0 0 2" +
                             kInformation + "\r\nFIX 5\n");
  ASSERT_EQ(contents.graph.nodeCount(), 2u);
  ASSERT_EQ(contents.graph.edgeCount(), 2u);
  EXPECT_EQ(contents.node_of_vertex.at(5), NodeId{1});
  const auto& second = contents.graph.getNode<CNodeKeyframe>({1});
  EXPECT_EQ(second.T_map_node.t, Vector3(1, 2, 3));
  EXPECT_NEAR(rotationAngle(second.T_map_node), 2 * std::acos(0.8), 1e-12);
  const auto* edge = dynamic_cast<const CEdgeLoopClosure*>(contents.graph.edgeSlots()[0].get());
  ASSERT_TRUE(edge) << "0 → 5 is no odometry";
  EXPECT_TRUE(edge->T_1_2.R.isIdentity(1e-15)) << "quaternions are normalised";
  const auto* prior = dynamic_cast<const CEdgePosePrior*>(contents.graph.edgeSlots()[1].get());
  ASSERT_TRUE(prior);
  EXPECT_EQ(prior->T_map_node.t, Vector3(1, 2, 3));
}

TEST(G2oReader, ConvertsTheInformationOfHalfAngles) {
  const auto contents = read(kVertices + "EDGE_SE3:QUAT 0 5" + kIdentityPose + kInformation);
  const VectorX diagonal = contents.graph.edgeSlots()[0]->information().diagonal();
  EXPECT_EQ(diagonal, (VectorX(6) << 1, 2, 3, 1, 2, 3).finished());
}

TEST(G2oReader, ConsecutiveIdsAreOdometry) {
  const auto contents = read("VERTEX_SE3:QUAT 4" + kIdentityPose + "\nVERTEX_SE3:QUAT 3" +
                             kIdentityPose + "\nEDGE_SE3:QUAT 3 4" + kIdentityPose + kInformation);
  EXPECT_TRUE(dynamic_cast<const CEdgeOdometry*>(contents.graph.edgeSlots()[0].get()));
  EXPECT_EQ(contents.node_of_vertex.at(3), NodeId{0}) << "in the order of ids, not of lines";
}

TEST(G2oReader, MalformedFilesNameTheLine) {
  const std::string edge = "EDGE_SE3:QUAT 0 5" + kIdentityPose;
  const struct {
    std::string text;
    const char *line, *what;
  } cases[] = {
      {"", "graph.g2o", "VERTEX_SE3:QUAT"},
      {"VERTEX_SE2 0 0 0 0\n", "line 1", "VERTEX_SE2"},
      {kVertices + "garbage\n", "line 3", "garbage"},
      {kVertices + std::string("\x00\xff\x01", 3), "line 3", "unknown record"},
      {kVertices + edge + "\n", "line 3", "end of the line"},
      {kVertices + edge + kInformation + " 7\n", "line 3", "more values"},
      {kVertices + "EDGE_SE3:QUAT 0 9" + kIdentityPose + kInformation, "line 3", "vertex 9"},
      {kVertices + "EDGE_SE3:QUAT 0 0" + kIdentityPose + kInformation, "line 3", "itself"},
      {kVertices + "EDGE_SE3:QUAT 0 -5" + kIdentityPose + kInformation, "line 3", "-5"},
      {kVertices + "EDGE_SE3:QUAT 0 1.5" + kIdentityPose + kInformation, "line 3", "1.5"},
      {kVertices + "VERTEX_SE3:QUAT 5" + kIdentityPose, "line 3", "twice"},
      {"VERTEX_SE3:QUAT 0 nan 0 0 0 0 0 1\n", "line 1", "not finite"},
      {"VERTEX_SE3:QUAT 0 1e999 0 0 0 0 0 1\n", "line 1", "1e999"},
      {"VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n", "line 1", "quaternion"},
      {"VERTEX_SE3:QUAT 0 x 0 0 0 0 0 1\n", "line 1", "'x'"},
      {"VERTEX_SE3:QUAT 99999999999999999999999" + kIdentityPose, "line 1", "999"},
      {kVertices + "FIX 17\n", "line 3", "vertex 17"},
      {kVertices + "FIX\n", "line 3", "vertex id"},
  };
  for (const auto& c : cases) {
    const std::string message = complaint(c.text);
    EXPECT_CONTAINS(message, "graph.g2o");
    EXPECT_CONTAINS(message, c.line);
    EXPECT_CONTAINS(message, c.what);
  }
  EXPECT_THROW(readG2o(std::filesystem::path("/nonexistent.g2o")), DataError);
  EXPECT_THROW(readG2o(std::filesystem::path("/")), DataError);
}

TEST(G2oReader, IndefiniteInformationIsAnErrorOrRepairedByChoice) {
  const std::string text = kVertices + "EDGE_SE3:QUAT 0 5" + kIdentityPose +
                           " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 4 9 0 4 0 4\n";
  const std::string message = complaint(text);
  for (const char* part : {"line 3", "0 -> 5", "not positive definite"})
    EXPECT_CONTAINS(message, part);
  G2oReadOptions repair;
  repair.indefinite = G2oReadOptions::Indefinite::kRepair;
  const auto contents = read(text, repair);
  EXPECT_EQ(contents.repaired_edges, 1u);
  const MatrixX information = contents.graph.edgeSlots()[0]->information();
  EXPECT_TRUE(squareRootInformation(information));
  EXPECT_NEAR(information(0, 0), 1.0, 1e-12) << "what was sound stays";
  const std::string zero = kVertices + "EDGE_SE3:QUAT 0 5" + kIdentityPose +
                           " 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n";
  EXPECT_CONTAINS(complaint(zero, repair), "not positive definite");
}

TEST(G2oReader, RandomDamageIsAnErrorAtWorst) {
  std::ostringstream out;
  writeG2o(out, generateGraph({.seed = 1}, 6));
  const std::string sound = out.str();
  std::mt19937_64 rng(2);
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = sound;
    for (int hits = 0; hits < 3; ++hits) damaged[rng() % damaged.size()] = static_cast<char>(rng());
    if (i % 3 == 0) damaged.resize(rng() % damaged.size());
    complaint(damaged);  // any other exception fails the test
  }
}

TEST(G2oWriter, ReadsBackToTheSameNumbers) {
  const CSceneGraph graph = generateGraph({.seed = 3}, 80);
  std::ostringstream first, second;
  writeG2o(first, graph, {.entities = true});
  const auto contents = read(first.str());
  writeG2o(second, contents.graph, {.entities = true});
  std::size_t poses = 0, relative = 0;
  for (const auto& node : graph.nodeSlots())
    poses += dynamic_cast<const CNodePose*>(node.get()) != nullptr;
  for (const auto& edge : graph.edgeSlots()) {
    const auto* ours = dynamic_cast<const CEdgeRelativePose*>(edge.get());
    if (!ours) continue;
    ++relative;
  }
  EXPECT_EQ(contents.graph.nodeCount(), poses);
  EXPECT_EQ(contents.graph.edgeCount(), relative + 1) << "and the fixed pose";
  for (const auto& keyframe : graph.keyframes()) {
    const NodeId id = contents.node_of_vertex.at(keyframe->id.value);
    EXPECT_LT(
        local(keyframe->T_map_node, contents.graph.getNode<CNodeKeyframe>(id).T_map_node).norm(),
        1e-12);
  }
  double cost = 0.0;
  for (const auto& edge : graph.edgeSlots()) {
    if (dynamic_cast<const CEdgeRelativePose*>(edge.get())) cost += graph.edgeCost(*edge);
  }
  EXPECT_NEAR(contents.graph.totalCost(), cost, 1e-9 * cost)
      << "information converts there and back";
}

TEST(G2oWriter, EntitiesOnlyWhenAsked) {
  const CSceneGraph graph = generateGraph({.seed = 4}, 10);
  std::ostringstream without;
  writeG2o(without, graph);
  const auto contents = read(without.str());
  EXPECT_EQ(contents.graph.nodeCount(), 10u);
  EXPECT_EQ(contents.graph.edgeCount(), 9u + 1u);
}

TEST(G2oReader, TakesG2osResidualToTheLetterWhenAsked) {
  G2oReadOptions options;
  options.residual = G2oReadOptions::Residual::kG2o;
  const auto contents = read(kVertices + "EDGE_SE3:QUAT 0 5 1 2 3 0 0 0 1" + kInformation, options);
  // t agrees; q_z = 0.6 with information 12.
  EXPECT_NEAR(contents.graph.totalCost(), 0.5 * 12 * 0.36, 1e-12);
  std::ostringstream out;
  writeG2o(out, contents.graph);
  EXPECT_CONTAINS(out.str(), " 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 8 0 12\n");
}

const std::string kMrptGraph =
    "VERTEX3 3 0 0 0 0 0 0 | start\n"
    "VERTEX3 7 1 2 3 0.1 0.2 0.3\n"
    "FIX 3\n"
    "EDGE3 3 7 1 2 3 0.1 0.2 0.3 4 0 0 0 0 0 5 0 0 0 0 6 0 0 0 70 0 0 80 0 90\n";

TEST(G2oReader, ReadsMrptsGraphs) {
  const auto contents = read(kMrptGraph);
  EXPECT_EQ(contents.graph.nodeCount(), 2u);
  EXPECT_EQ(contents.relative_edges, 1u);
  EXPECT_TRUE(contents.fixed);
  const auto& second = contents.graph.getNode<CNodeKeyframe>(contents.node_of_vertex.at(7));
  const Pose3 expected = Pose3::fromYawPitchRoll(1, 2, 3, 0.3, 0.2, 0.1);
  EXPECT_LT(local(expected, second.T_map_node).norm(), 1e-12);
  EXPECT_LT(contents.graph.totalCost(), 1e-20);
  // A turn by yaw alone costs ½ · 90 · δ².
  auto moved = read(kMrptGraph);
  const double d = 1e-4;
  moved.graph.keyframes()[1]->T_map_node = Pose3::fromYawPitchRoll(1, 2, 3, 0.3 + d, 0.2, 0.1);
  EXPECT_NEAR(moved.graph.totalCost(), 0.5 * 90 * d * d, 1e-3 * 90 * d * d);
}

TEST(G2oReader, MissingInformationOfAnMrptEdgeIsTheIdentity) {
  const auto contents =
      read("VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 0 0 0 0 0\nEDGE3 0 1 1 0 0 0 0 0\n");
  EXPECT_TRUE(contents.graph.edgeSlots()[0]->information().isIdentity(1e-12));
  EXPECT_FALSE(contents.fixed);
}

TEST(G2oReader, EquivalentVerticesBecomeOne) {
  const auto contents = read(
      "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 0 0 0 0 0\nVERTEX3 2 5 0 0 0 0 0\n"
      "EDGE3 0 1 1 0 0 0 0 0\nEDGE3 1 2 4 0 0 0 0 0\nEQUIV 2 0\n");
  EXPECT_EQ(contents.graph.nodeCount(), 2u);
  EXPECT_EQ(contents.relative_edges, 2u);
  EXPECT_EQ(contents.graph.edgeSlots()[1]->nodes[1], contents.node_of_vertex.at(0));
}

TEST(G2oReader, NamesTheEdgeOfAnMrptGraphWithoutPositiveDefiniteInformation) {
  std::string text = kMrptGraph;
  text.replace(text.find(" 90\n"), 4, " -9\n");
  EXPECT_CONTAINS(complaint(text), "line 4: the information matrix of edge 3 -> 7");
  G2oReadOptions repair;
  repair.indefinite = G2oReadOptions::Indefinite::kRepair;
  EXPECT_EQ(read(text, repair).repaired_edges, 1u);
}

TEST(G2oRewriter, ReplacesThePosesAndCopiesTheRest) {
  for (const std::string& text :
       {"# comment\n" + kMrptGraph,
        kVertices + "EDGE_SE3:QUAT 0 5" + kIdentityPose + kInformation + "\n"}) {
    auto contents = read(text);
    contents.graph.keyframes()[1]->T_map_node = Pose3::fromYawPitchRoll(-4, 5, 6, 1, -0.5, 0.25);
    std::istringstream in(text);
    std::ostringstream out;
    rewriteG2o(in, "graph", contents, out);
    const auto again = read(out.str());
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_LT(
          local(contents.graph.keyframes()[i]->T_map_node, again.graph.keyframes()[i]->T_map_node)
              .norm(),
          1e-12);
    }
    const std::string edges = text.substr(text.find("EDGE"));
    EXPECT_CONTAINS(out.str(), edges);
  }
}

}  // namespace
}  // namespace dynemo::test
