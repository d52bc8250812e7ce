// The assembled normal equations against dense sums and numeric derivatives.
#include "linearize.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"

namespace dynemo::test {
namespace {

using namespace backend;

struct Assembled {
  explicit Assembled(const CSceneGraph& graph)
      : problem(graph),
        adjacency(adjacencyOf(problem.connectivity())),
        structure(problem.connectivity(), adjacency, eliminationOrder(adjacency, context).order),
        states(problem.readStates()) {
    linearize(problem, structure, states, equations);
  }
  /// H as a full matrix, from its lower triangle.
  MatrixX dense() const {
    const cholmod_sparse A = structure.view(nullptr);
    const int *begin = static_cast<const int*>(A.p), *row = static_cast<const int*>(A.i);
    MatrixX H = MatrixX::Zero(structure.size(), structure.size());
    for (int c = 0; c < structure.size(); ++c)
      for (int k = begin[c]; k < begin[c + 1]; ++k)
        if (row[k] >= c) H(row[k], c) = H(c, row[k]) = equations.hessian[k];
    return H;
  }
  CholmodContext context;
  Problem problem;
  Adjacency adjacency;
  BlockStructure structure;
  std::vector<double> states;
  NormalEquations equations;
};

/// Σ ρ' JᵀΩJ straight from the edges.
MatrixX denseHessian(const CSceneGraph& graph, const Assembled& a) {
  MatrixX H = MatrixX::Zero(a.structure.size(), a.structure.size());
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge) continue;
    std::vector<const double*> pointers;
    for (const NodeId n : edge->nodes)
      pointers.push_back(&a.states[a.problem.stateOffset(a.problem.variableOf(n))]);
    Residual e;
    Jacobians J;
    edge->evaluate(pointers, e, &J);
    const MatrixX omega =
        edge->kernel(e.dot(edge->information() * e)).weight * MatrixX(edge->information());
    const auto offset = [&](std::size_t i) {
      return a.structure.tangentOffset(a.problem.variableOf(edge->nodes[i]));
    };
    for (std::size_t i = 0; i < pointers.size(); ++i)
      for (std::size_t k = 0; k < pointers.size(); ++k) {
        H.block(offset(i), offset(k), J[i].cols(), J[k].cols()) += J[i].transpose() * omega * J[k];
      }
  }
  return H;
}

VectorX numericGradient(const Assembled& a) {
  constexpr double kStep = 1e-6;
  VectorX g(a.structure.size());
  std::vector<double> moved;
  for (int i = 0; i < a.structure.size(); ++i) {
    const VectorX d = kStep * VectorX::Unit(a.structure.size(), i);
    retract(a.problem, a.structure, a.states, d, moved);
    const double plus = evaluateCost(a.problem, moved);
    retract(a.problem, a.structure, a.states, -d, moved);
    g[i] = (plus - evaluateCost(a.problem, moved)) / (2 * kStep);
  }
  return g;
}

void expectRightNormalEquations(const CSceneGraph& graph) {
  const Assembled a(graph);
  const MatrixX expected = denseHessian(graph, a), actual = a.dense();
  EXPECT_LT((actual - expected).norm(), 1e-12 * expected.norm());
  EXPECT_LT((a.equations.gradient - numericGradient(a)).norm(), 1e-6 * a.equations.gradient.norm());
  EXPECT_NEAR(a.equations.cost, graph.totalCost(), 1e-12 * graph.totalCost());
  EXPECT_EQ(a.equations.cost, evaluateCost(a.problem, a.states))
      << "two ways to the same sum, bit for bit";
}

TEST(Linearize, EveryKindOfEdge) { expectRightNormalEquations(generateGraph({.seed = 5}, 70)); }

TEST(Linearize, RobustKernels) {
  expectRightNormalEquations(generateGraph({.seed = 6, .outliers = true}, 70));
}

TEST(Linearize, AnEdgeFromANodeToItself) {
  CSceneGraph graph = generateGraph({.seed = 7}, 3);
  std::mt19937_64 rng(1);
  GraphDelta delta;
  auto loop = CEdgeLoopClosure::example(rng);
  loop->id = graph.nextEdgeId();
  loop->nodes = {graph.keyframes()[1]->id, graph.keyframes()[1]->id};
  delta.edges.push_back(loop);
  graph.apply(delta);
  expectRightNormalEquations(graph);
}

TEST(Linearize, RemovedEdgesAndLonelyNodesAreLeftOut) {
  CSceneGraph graph = generateGraph({.seed = 8}, 10);
  GraphDelta delta;
  delta.removed_edges = graph.edgesOf(graph.keyframes().back()->id);
  graph.apply(delta);
  const Problem problem(graph);
  EXPECT_EQ(problem.variableOf(graph.keyframes().back()->id), -1);
  EXPECT_GE(problem.variableOf(graph.keyframes().front()->id), 0);
  EXPECT_EQ(static_cast<std::size_t>(problem.connectivity().factors()), graph.edgeCount());
  expectRightNormalEquations(graph);
}

TEST(Ordering, IsAPermutationBelowAndAboveTheSwitchToNestedDissection) {
  for (const int keyframes : {1, 20, 400}) {
    const CSceneGraph graph = generateGraph({.seed = 9}, keyframes);
    const Problem problem(graph);
    Adjacency adjacency = adjacencyOf(problem.connectivity());
    CholmodContext context;
    std::vector<int> order = eliminationOrder(adjacency, context).order;
    std::sort(order.begin(), order.end());
    for (int i = 0; i < problem.connectivity().variables(); ++i) ASSERT_EQ(order[i], i);
    EXPECT_EQ(static_cast<int>(order.size()), problem.connectivity().variables());
  }
}

}  // namespace
}  // namespace dynemo::test
