#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "dynemo/backend/optimizer.h"
#include "generated_graph.h"

namespace dynemo::test {
namespace {

/// H⁻¹ by dense algebra, straight from the edges; nodes in the order of their ids.
struct DenseReference {
  explicit DenseReference(const CSceneGraph& graph) {
    int n = 0;
    for (const auto& node : graph.nodeSlots()) {
      offset.push_back(n);
      n += node->tangentSize();
    }
    offset.push_back(n);
    MatrixX H = MatrixX::Zero(n, n);
    for (const auto& edge : graph.edgeSlots()) {
      std::vector<std::vector<double>> states;
      std::vector<const double*> pointers;
      for (const NodeId id : edge->nodes) {
        states.emplace_back(16);
        graph.nodeSlots()[id.value]->readState(states.back().data());
      }
      for (const auto& s : states) pointers.push_back(s.data());
      Residual e;
      Jacobians J;
      edge->evaluate(pointers, e, &J);
      const MatrixX omega =
          edge->kernel(e.dot(edge->information() * e)).weight * MatrixX(edge->information());
      for (std::size_t a = 0; a < edge->nodes.size(); ++a)
        for (std::size_t b = 0; b < edge->nodes.size(); ++b) {
          H.block(offset[edge->nodes[a].value], offset[edge->nodes[b].value], J[a].cols(),
                  J[b].cols()) += J[a].transpose() * omega * J[b];
        }
    }
    covariance = H.ldlt().solve(MatrixX::Identity(n, n));
  }
  MatrixX block(NodeId a, NodeId b) const {
    return covariance.block(offset[a.value], offset[b.value], offset[a.value + 1] - offset[a.value],
                            offset[b.value + 1] - offset[b.value]);
  }
  std::vector<int> offset;
  MatrixX covariance;
};

class Marginals : public ::testing::TestWithParam<bool> {
 protected:
  Marginals()
      : graph_(generateGraph({.seed = 21, .observations_per_keyframe = 2, .outliers = GetParam()},
                             70)) {
    optimizer_.optimize(graph_);
  }
  Optimizer optimizer_{SolverParams{}};
  CSceneGraph graph_;
};

TEST_P(Marginals, JointCovarianceEqualsTheDenseInverse) {
  const DenseReference dense(graph_);
  // Keyframes, entities and a floor, not in order.
  const std::vector<NodeId> nodes = {
      graph_.keyframes()[40]->id, {2}, graph_.floors()[0]->id, graph_.keyframes()[3]->id};
  const auto joint = optimizer_.marginalCovariance(graph_, nodes);
  ASSERT_TRUE(joint) << joint.error();
  int row = 0;
  for (const NodeId a : nodes) {
    int column = 0;
    for (const NodeId b : nodes) {
      const MatrixX expected = dense.block(a, b);
      EXPECT_LT((joint->block(row, column, expected.rows(), expected.cols()) - expected).norm(),
                1e-8 * dense.covariance.norm());
      column += static_cast<int>(expected.cols());
    }
    row += static_cast<int>(dense.block(a, a).rows());
  }
  EXPECT_EQ(row, joint->rows());
}

TEST_P(Marginals, BlocksOfAllNodesEqualTheDenseInverse) {
  const DenseReference dense(graph_);
  std::vector<NodeId> nodes;
  for (const auto& node : graph_.nodeSlots()) nodes.push_back(node->id);
  const auto blocks = optimizer_.marginalBlocks(graph_, nodes);
  ASSERT_TRUE(blocks) << blocks.error();
  ASSERT_EQ(blocks->size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const MatrixX expected = dense.block(nodes[i], nodes[i]);
    EXPECT_LT(((*blocks)[i] - expected).norm(), 1e-7 * expected.norm()) << "node " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(WithoutAndWithKernels, Marginals, ::testing::Bool());

TEST(MarginalBlocks, AgreeWithTheJointOnALargeGraph) {
  CSceneGraph graph = generateGraph({.seed = 22}, 400);
  Optimizer optimizer({});
  optimizer.optimize(graph);
  std::vector<NodeId> some;
  for (std::uint64_t i = 1; i < graph.nodeCount(); i += 97) some.push_back({i});
  const auto joint = optimizer.marginalCovariance(graph, some);
  const auto blocks = optimizer.marginalBlocks(graph, some);
  ASSERT_TRUE(joint && blocks);
  Eigen::Index at = 0;
  for (const MatrixX& block : *blocks) {
    EXPECT_LT((joint->block(at, at, block.rows(), block.rows()) - block).norm(),
              1e-6 * block.norm());
    at += block.rows();
  }
  EXPECT_EQ(at, joint->rows());
}

TEST(MarginalCovariance, UncertaintyGrowsAlongADeadReckonedChain) {
  CSceneGraph graph = generateGraph({.seed = 23, .observations_per_keyframe = 1}, 40);
  Optimizer optimizer({});
  optimizer.optimize(graph);
  const std::vector<NodeId> nodes = {graph.keyframes()[1]->id, graph.keyframes()[20]->id,
                                     graph.keyframes()[39]->id};
  const auto blocks = optimizer.marginalBlocks(graph, nodes);
  ASSERT_TRUE(blocks) << blocks.error();
  EXPECT_LT((*blocks)[0].trace(), (*blocks)[1].trace());
  EXPECT_LT((*blocks)[1].trace(), (*blocks)[2].trace());
}

TEST(MarginalCovariance, FreeGaugeIsAFailure) {
  for (const bool outliers : {false, true}) {
    CSceneGraph graph = generateGraph({.seed = 24, .outliers = outliers, .pose_prior = false}, 60);
    Optimizer optimizer({});
    optimizer.optimize(graph);
    const std::vector<NodeId> nodes = {graph.keyframes()[1]->id};
    const auto joint = optimizer.marginalCovariance(graph, nodes);
    ASSERT_FALSE(joint);
    EXPECT_NE(joint.error().find("gauge"), std::string::npos) << joint.error();
    EXPECT_FALSE(optimizer.marginalBlocks(graph, nodes));
  }
}

TEST(MarginalCovariance, NodesWithoutEdgesAreAFailure) {
  CSceneGraph graph = generateGraph({.seed = 25}, 5);
  Optimizer optimizer({});
  const std::vector<NodeId> unknown = {{9999}};
  EXPECT_FALSE(optimizer.marginalCovariance(graph, unknown));
  EXPECT_FALSE(optimizer.marginalBlocks(graph, unknown));
  EXPECT_EQ(optimizer.marginalCovariance(graph, {})->size(), 0);
  EXPECT_TRUE(optimizer.marginalBlocks(graph, {})->empty());
}

TEST(MarginalCovariance, WorksWithoutOptimisingFirst) {
  const CSceneGraph graph = generateGraph({.seed = 26}, 10);
  Optimizer optimizer({});
  const std::vector<NodeId> nodes = {graph.keyframes()[4]->id};
  EXPECT_TRUE(optimizer.marginalCovariance(graph, nodes));
}

TEST(MarginalCovariance, NotFiniteIsAFailure) {
  CSceneGraph graph = generateGraph({.seed = 27}, 10);
  graph.keyframes()[3]->T_map_node.t.z() = std::nan("");
  Optimizer optimizer({});
  const std::vector<NodeId> nodes = {graph.keyframes()[4]->id};
  const auto joint = optimizer.marginalCovariance(graph, nodes);
  ASSERT_FALSE(joint);
  EXPECT_NE(joint.error().find("not finite"), std::string::npos) << joint.error();
}

}  // namespace
}  // namespace dynemo::test
