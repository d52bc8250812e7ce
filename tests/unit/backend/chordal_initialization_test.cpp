#include "dynemo/backend/chordal_initialization.h"

#include <gtest/gtest.h>

#include "dynemo/backend/g2o_io.h"
#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"
#include "pose_graph_files.h"

namespace dynemo::test {
namespace {

/// `parts` rings of poses that fit exactly, from random estimates but for the first pose of each.
CSceneGraph exactRings(std::size_t parts, std::size_t size, std::vector<Pose3>& truth) {
  std::mt19937_64 rng(17);
  CSceneGraph graph;
  GraphDelta delta;
  for (std::size_t i = 0; i < parts * size; ++i) {
    truth.push_back(randomPose(rng));
    auto node = std::make_shared<CNodeKeyframe>();
    node->id = {i};
    node->T_map_node = i % size == 0 ? truth[i] : randomPose(rng);
    delta.nodes.push_back(node);
  }
  for (std::size_t i = 0; i < parts * size; ++i) {
    const std::size_t next = i % size + 1 == size ? i + 1 - size : i + 1;
    auto edge = std::make_shared<CEdgeOdometry>();
    edge->id = {i};
    edge->nodes = {{i}, {next}};
    edge->T_1_2 = truth[i].inverse() * truth[next];
    edge->setInformation(randomInformation(6, rng));
    delta.edges.push_back(edge);
  }
  graph.apply(delta);
  return graph;
}

TEST(ChordalInitialization, SolvesExactGraphsFromAnyStart) {
  for (const std::size_t parts : {1u, 3u}) {
    std::vector<Pose3> truth;
    CSceneGraph graph = exactRings(parts, 8, truth);
    EXPECT_GT(graph.totalCost(), 1.0);
    const auto done = initializeChordal(graph);
    ASSERT_TRUE(done) << done.error();
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_LT(local(truth[i], graph.keyframes()[i]->T_map_node).norm(), 1e-9) << "pose " << i;
    }
  }
}

TEST(ChordalInitialization, APoseWithAPriorStays) {
  std::vector<Pose3> truth;
  CSceneGraph graph = exactRings(1, 8, truth);
  const NodeId fixed = graph.keyframes()[5]->id;
  const auto prior = std::make_shared<CEdgePosePrior>();
  prior->id = graph.nextEdgeId();
  prior->nodes = {fixed};
  prior->T_map_node = graph.keyframes()[5]->T_map_node;
  prior->setInformation(MatrixX::Identity(6, 6));
  GraphDelta delta;
  delta.edges = {prior};
  graph.apply(delta);
  ASSERT_TRUE(initializeChordal(graph));
  EXPECT_LT(local(prior->T_map_node, graph.keyframes()[5]->T_map_node).norm(), 1e-12);
  EXPECT_LT(graph.totalCost(), 1e-9);
}

TEST(ChordalInitialization, NothingToDoIsNoFailure) {
  CSceneGraph empty;
  EXPECT_TRUE(initializeChordal(empty));
}

TEST(ChordalInitialization, LeavesFloorsAndLandsNearTheMinimumOfMixedGraphs) {
  CSceneGraph graph = generateGraph({.seed = 31, .planes = false}, 70);
  const double level = graph.floors()[0]->level_m;
  ASSERT_TRUE(initializeChordal(graph));
  EXPECT_EQ(graph.floors()[0]->level_m, level);
  const double started = graph.totalCost();
  const OptimizationReport report = Optimizer({}).optimize(graph);
  ASSERT_TRUE(report.usable());
  EXPECT_LT(started, 50.0 * report.cost_after);
}

TEST(ChordalInitialization, MakesTheSmallGridEasy) {
  auto contents = readG2o(std::filesystem::path(DYNEMO_TEST_POSE_GRAPHS) / "smallGrid3D.g2o");
  const double guess = contents.graph.totalCost();
  ASSERT_TRUE(initializeChordal(contents.graph));
  const double chordal = contents.graph.totalCost();
  EXPECT_LT(chordal, 0.1 * guess);
  const OptimizationReport report = Optimizer({}).optimize(contents.graph);
  EXPECT_LT(report.iterations, 8);
  EXPECT_LT(report.cost_after, chordal);
}

}  // namespace
}  // namespace dynemo::test
