// The parts of the multifrontal factorisation, each against dense algebra.
#include "front_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>
#include <random>

#include "block_arena.h"
#include "dense_kernels.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "generated_graph.h"

namespace dynemo::test {
namespace {

using namespace backend;

MatrixX randomSpd(int n, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  MatrixX A(n, n);
  for (double& a : A.reshaped()) a = std::normal_distribution<double>()(rng);
  return A * A.transpose() + MatrixX::Identity(n, n);
}

/// With the rows that the kernels ask for below it.
MatrixX padded(const MatrixX& A) {
  MatrixX work = MatrixX::Zero(A.rows() + kPaddingRows, A.cols());
  work.topRows(A.rows()) = A;
  return work;
}

/// Sizes on both sides of every threshold of the kernels.
class Kernels : public ::testing::TestWithParam<std::pair<int, int>> {};

TEST_P(Kernels, FactorizePivotsAsTheDenseAlgebra) {
  const auto [rows, pivots] = GetParam();
  const MatrixX A = randomSpd(rows, 7);
  MatrixX work = padded(A);
  ASSERT_EQ(factorizePivots(work.data(), rows + kPaddingRows, rows, pivots), -1);
  EXPECT_TRUE(work.bottomRows(kPaddingRows).isZero(0.0));
  work.conservativeResize(rows, rows);
  const MatrixX L = A.llt().matrixL();
  const MatrixX panel = work.leftCols(pivots).triangularView<Eigen::Lower>();
  EXPECT_LT((panel - L.leftCols(pivots)).norm(), 1e-10 * L.norm());
  const MatrixX schur = A - L.leftCols(pivots) * L.leftCols(pivots).transpose();
  const int r = rows - pivots;
  const MatrixX difference = work.bottomRightCorner(r, r) - schur.bottomRightCorner(r, r);
  EXPECT_LT(MatrixX(difference.triangularView<Eigen::Lower>()).norm(), 1e-9 * A.norm());
}

TEST_P(Kernels, FindTheFirstBadPivot) {
  const auto [rows, pivots] = GetParam();
  for (const int bad : {0, pivots / 2, pivots - 1}) {
    MatrixX A = randomSpd(rows, 8);
    const MatrixX L = A.llt().matrixL();
    A(bad, bad) -= 1.001 * L(bad, bad) * L(bad, bad);
    MatrixX work = padded(A);
    EXPECT_EQ(factorizePivots(work.data(), rows + kPaddingRows, rows, pivots), bad);
  }
}

TEST_P(Kernels, BackSubstitutionSolves) {
  const auto [rows, pivots] = GetParam();
  MatrixX L = padded(randomSpd(rows, 9));
  factorizePivots(L.data(), rows + kPaddingRows, rows, pivots);
  L.conservativeResize(rows, rows);
  const VectorX x = VectorX::LinSpaced(rows, -1.0, 2.0);
  VectorX y = MatrixX(L.leftCols(pivots).triangularView<Eigen::Lower>()).transpose() * x;
  backSubstitute(L.data(), rows, rows, pivots, x.data() + pivots, y.data());
  EXPECT_LT((y - x.head(pivots)).norm(), 1e-9 * x.norm());
}

TEST_P(Kernels, ForwardSubstitutionEliminatesAllSides) {
  const auto [rows, pivots] = GetParam();
  MatrixX L = padded(randomSpd(rows, 10));
  factorizePivots(L.data(), rows + kPaddingRows, rows, pivots);
  L.conservativeResize(rows, rows);
  std::mt19937_64 rng(11);
  MatrixX x(kSides, rows);
  for (double& entry : x.reshaped()) entry = std::normal_distribution<double>()(rng);
  const MatrixX b = x.transpose();
  forwardSubstituteSides(L.data(), rows, rows, pivots, x.data());
  MatrixX one = b;
  for (int side = 0; side < kSides; ++side)
    forwardSubstitute(L.data(), rows, rows, pivots, one.col(side).data());
  EXPECT_LT((x.transpose() - one).norm(), 1e-9 * b.norm());
  const MatrixX panel = L.leftCols(pivots).triangularView<Eigen::Lower>();
  MatrixX back = panel * x.leftCols(pivots).transpose();
  back.bottomRows(rows - pivots) += x.rightCols(rows - pivots).transpose();
  EXPECT_LT((back - b).norm(), 1e-9 * panel.norm() * b.norm());
}

INSTANTIATE_TEST_SUITE_P(Sizes, Kernels,
                         ::testing::Values(std::pair{1, 1}, std::pair{7, 6}, std::pair{36, 24},
                                           std::pair{37, 24}, std::pair{49, 48}, std::pair{97, 49},
                                           std::pair{130, 96}, std::pair{151, 150}));

TEST(BlockArena, BlocksDoNotOverlapAndAreUsedAgain) {
  BlockArena arena;
  std::mt19937_64 rng(3);
  std::vector<BlockArena::Block> blocks(200);
  std::vector<std::size_t> sizes(blocks.size());
  for (int round = 0; round < 20; ++round) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      sizes[i] = 1 + rng() % (i % 50 == 0 ? 200'000 : 3'000);
      arena.reserve(blocks[i], sizes[i]);
      std::fill_n(blocks[i].data, sizes[i], static_cast<double>(i));
    }
    for (std::size_t i = 0; i < blocks.size(); ++i)
      for (const std::size_t at : {std::size_t{0}, sizes[i] - 1})
        ASSERT_EQ(blocks[i].data[at], static_cast<double>(i));
  }
  const std::size_t capacity = arena.capacity();
  for (auto& block : blocks) {
    const std::size_t size = block.capacity;
    arena.release(block);
    arena.reserve(block, size);
  }
  EXPECT_EQ(arena.capacity(), capacity);
}

TEST(BlockArena, BigBlocksStandByOnlyWhereTheyAreSoonWanted) {
  constexpr std::size_t kSize = 300'000;
  for (const bool keep : {false, true}) {
    BlockArena arena;
    arena.keepBig(keep);
    std::vector<BlockArena::Block> blocks(8);
    for (auto& block : blocks) arena.reserve(block, kSize);
    const std::size_t all = arena.capacity();
    for (auto& block : blocks) arena.release(block);
    EXPECT_EQ(arena.capacity() == all, keep);
    for (int i = 0; i < 2; ++i) arena.reserve(blocks[i], kSize);
    arena.clear();
    // Two were in use.
    EXPECT_EQ(arena.capacity() >= 2 * kSize, keep);
    EXPECT_LT(arena.capacity(), all / 2);
    blocks.assign(2, {});
    const std::size_t kept = arena.capacity();
    for (auto& block : blocks) {
      arena.reserve(block, kSize);
      std::fill_n(block.data, kSize, 1.0);
    }
    EXPECT_EQ(arena.capacity() == kept, keep);
  }
}

/// H and −g of a live problem, densely.
struct Dense {
  explicit Dense(LiveProblem& problem)
      : H(MatrixX::Zero(problem.tangentSize(), problem.tangentSize())),
        b(VectorX::Zero(problem.tangentSize())) {
    WhitenedFactor work;
    for (int f = 0; f < problem.factors(); ++f) {
      if (!problem.edge(f)) continue;
      problem.linearize(f, work);
      const auto variables = problem.variablesOf(f);
      for (std::size_t i = 0; i < variables.size(); ++i) {
        const int at = problem.tangentOffset(variables[i]);
        b.segment(at, work.J[i].cols()) -= work.J[i].transpose() * work.e;
        for (std::size_t j = 0; j < variables.size(); ++j) {
          H.block(at, problem.tangentOffset(variables[j]), work.J[i].cols(), work.J[j].cols()) +=
              work.J[i].transpose() * work.J[j];
        }
      }
    }
  }
  MatrixX H;
  VectorX b;
};

void expectSolved(LiveProblem& problem, const FrontFactor& factor) {
  const Dense dense(problem);
  const VectorX expected = dense.H.ldlt().solve(dense.b);
  const VectorX actual = Eigen::Map<const VectorX>(problem.delta(0), problem.tangentSize());
  EXPECT_LT((actual - expected).norm(), 1e-7 * (1.0 + expected.norm()));
  EXPECT_NEAR(factor.modelDecrease(), 0.5 * dense.b.dot(expected),
              1e-6 * (1.0 + factor.modelDecrease()));
}

TEST(FrontFactor, SolvesAfterEveryChange) {
  const CSceneGraph graph =
      generateGraph({.seed = 31, .keyframes_per_lap = 16, .loop_every = 5}, 60);
  LiveProblem problem;
  CholmodContext context;
  FrontFactor factor;
  const auto& edges = graph.edgeSlots();
  std::size_t next = 0;
  const auto addUpTo = [&](std::size_t end, bool built) {
    std::vector<int> variables, factors;
    for (; next < end; ++next) {
      for (const NodeId node : edges[next]->nodes)
        if (problem.variableOf(node) < 0)
          variables.push_back(problem.addVariable(graph.nodeSlots()[node.value]));
      factors.push_back(problem.addFactor(edges[next]));
    }
    if (!built) return;
    factor.tree().append(problem, variables);
    for (const int f : factors) factor.tree().addFactor(problem, f);
  };
  addUpTo(edges.size() / 2, false);
  factor.build(problem, context);
  ASSERT_FALSE(factor.factorize(problem));
  factor.solve(problem, 0.0);
  expectSolved(problem, factor);

  std::mt19937_64 rng(5);
  while (next < edges.size()) {
    addUpTo(std::min(edges.size(), next + 9), true);
    // A loop closure or a detection that turns out wrong, and a variable that has moved.
    const int f = static_cast<int>(rng() % static_cast<std::uint64_t>(problem.factors()));
    if (problem.edge(f) && std::string(problem.edge(f)->kind()) == "intra_entity") {
      factor.tree().removeFactor(problem, f);
      problem.removeFactor(f);
    }
    const int v = static_cast<int>(rng() % static_cast<std::uint64_t>(problem.variables()));
    problem.updateEstimate(v);
    problem.relinearize(v);
    problem.forEachFactorOf(v, [&](int g) { factor.tree().touchFactor(problem, g); });
    ASSERT_FALSE(factor.factorize(problem));
    EXPECT_LE(factor.lastFronts(), factor.tree().fronts());
    factor.solve(problem, 0.0);
    expectSolved(problem, factor);
  }
}

class Corrections : public ::testing::Test {
 protected:
  Corrections() {
    const CSceneGraph graph =
        generateGraph({.seed = 32, .keyframes_per_lap = 16, .loop_every = 5, .outliers = true}, 50);
    for (const auto& edge : graph.edgeSlots()) {
      for (const NodeId node : edge->nodes)
        if (problem_.variableOf(node) < 0) problem_.addVariable(graph.nodeSlots()[node.value]);
      problem_.addFactor(edge);
    }
    factor_.build(problem_, context_);
    EXPECT_FALSE(factor_.factorize(problem_));
    start_ = problem_;
    solve();
  }
  void solve() {
    factor_.solve(problem_, 0.0);
    for (int v = 0; v < problem_.variables(); ++v) problem_.updateEstimate(v);
    for (int f = 0; f < problem_.factors(); ++f) problem_.updateCost(f);
  }
  std::vector<int> all() const {
    std::vector<int> factors(static_cast<std::size_t>(problem_.factors()));
    std::iota(factors.begin(), factors.end(), 0);
    return factors;
  }
  LiveProblem problem_, start_;
  CholmodContext context_;
  FrontFactor factor_;
};

TEST_F(Corrections, MakeTheModelThatOfTheResidualsAtTheEstimates) {
  const double decrease = factor_.correct(problem_, all());
  WhitenedFactor model;
  for (int f = 0; f < problem_.factors(); ++f) {
    problem_.linearize(f, model);
    const auto variables = problem_.variablesOf(f);
    std::vector<const double*> states;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      const int v = variables[i];
      model.e += model.J[i] * Eigen::Map<const VectorX>(problem_.delta(v), problem_.tangentSize(v));
      states.push_back(problem_.estimate(v));
    }
    // J is scaled by the root of the old weight, so that Jᵀe has the new one.
    Residual e;
    const WeightedCost here = whitenedResidual(*problem_.edge(f), states, e);
    double old_weight = 1.0;
    WhitenedFactor start;
    std::vector<const double*> start_states;
    for (const int v : variables) start_states.push_back(start_.estimate(v));
    whitenedFactor(*problem_.edge(f), start_states, start, &old_weight);
    ASSERT_LT((std::sqrt(old_weight) * model.e - here.weight * e).norm(), 1e-5 * (1.0 + e.norm()));
  }
  EXPECT_NEAR(problem_.linearizedCost() - factor_.modelDecrease(), problem_.cost() - decrease,
              1e-7 * problem_.cost());
  factor_.solve(problem_, 0.0);
  expectSolved(problem_, factor_);
}

TEST_F(Corrections, DoNotPushTheMapAsAWhole) {
  // Relative poses do not change under a motion of everything: what is added to the gradient of
  // their two ends must not either, though the Jacobians have become others since.
  std::mt19937_64 rng(9);
  for (int i = 0; i < problem_.tangentSize(); ++i)
    problem_.delta(0)[i] += std::normal_distribution<double>(0.0, 0.05)(rng);
  for (int v = 0; v < problem_.variables(); ++v) problem_.updateEstimate(v);
  int relative = 0;
  WhitenedFactor work;
  for (int f = 0; f < problem_.factors(); ++f) {
    const auto variables = problem_.variablesOf(f);
    if (variables.size() != 2 || !dynamic_cast<const CEdgeRelativePose*>(problem_.edge(f).get()))
      continue;
    const Residual change = problem_.correct(f, work);
    Vector6 push = Vector6::Zero();
    double pull = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      const Pose3 T = CNodePose::poseFromState(start_.estimate(variables[i]));
      // The tangent of the node by a motion of the map.
      const Matrix6 A = composeJacobianLeft(T);
      const Vector6 g = work.J[i].transpose() * change;
      push += A.transpose() * g;
      pull += (A.transpose() * g).norm();
    }
    ASSERT_LT(push.norm(), 1e-9 * pull + 1e-12);
    ++relative;
  }
  EXPECT_GT(relative, 50);
}

TEST_F(Corrections, LastWhileFrontsAreFactorizedAgain) {
  factor_.correct(problem_, all());
  factor_.solve(problem_, 0.0);
  const VectorX corrected = Eigen::Map<const VectorX>(problem_.delta(0), problem_.tangentSize());
  const double model = problem_.linearizedCost() - factor_.modelDecrease();
  for (int f = 0; f < problem_.factors(); f += 7) factor_.tree().touchFactor(problem_, f);
  ASSERT_FALSE(factor_.factorize(problem_));
  EXPECT_GT(factor_.lastFronts(), 1);
  factor_.solve(problem_, 0.0);
  const VectorX again = Eigen::Map<const VectorX>(problem_.delta(0), problem_.tangentSize());
  EXPECT_LT((again - corrected).norm(), 1e-8 * (1.0 + corrected.norm()));
  EXPECT_NEAR(problem_.linearizedCost() - factor_.modelDecrease(), model, 1e-8 * model);
}

TEST_F(Corrections, LeadBackToTheMinimum) {
  for (int i = 0; i < 8; ++i) {
    for (int v = 0; v < problem_.variables(); ++v) {
      problem_.relinearize(v);
      factor_.forget(problem_, v);
    }
    factor_.tree().touchAll();
    ASSERT_FALSE(factor_.factorize(problem_));
    solve();
  }
  const double minimum = problem_.cost();
  std::mt19937_64 rng(4);
  for (int i = 0; i < problem_.tangentSize(); ++i)
    problem_.delta(0)[i] += std::normal_distribution<double>(0.0, 0.003)(rng);
  for (int v = 0; v < problem_.variables(); ++v) problem_.updateEstimate(v);
  for (int f = 0; f < problem_.factors(); ++f) problem_.updateCost(f);
  ASSERT_GT(problem_.cost(), 1.1 * minimum);
  for (int i = 0; i < 5; ++i) {
    factor_.correct(problem_, all());
    solve();
  }
  EXPECT_NEAR(problem_.cost(), minimum, 1e-4 * minimum);
}

TEST_F(Corrections, MixWithNewLinearizationsAndWeights) {
  std::mt19937_64 rng(6);
  for (int round = 0; round < 6; ++round) {
    std::vector<int> some;
    for (int v = 0; v < problem_.variables(); ++v) {
      if (rng() % 4 != 0) continue;
      problem_.relinearize(v);
      factor_.forget(problem_, v);
      problem_.forEachFactorOf(v, [&](int f) { factor_.tree().touchFactor(problem_, f); });
    }
    for (int f = 0; f < problem_.factors(); ++f) {
      if (rng() % 3 != 0) continue;
      some.push_back(f);
      if (rng() % 4 != 0) continue;
      problem_.reweigh(f);
      factor_.tree().touchFactor(problem_, f);
    }
    ASSERT_FALSE(factor_.factorize(problem_));
    factor_.correct(problem_, some);
    factor_.solve(problem_, 0.0);
    expectSolved(problem_, factor_);
    // A small part of the step, so that the graph stays where it is nearly linear.
    for (int i = 0; i < problem_.tangentSize(); ++i) problem_.delta(0)[i] *= 0.1;
    for (int v = 0; v < problem_.variables(); ++v) problem_.updateEstimate(v);
    for (int f = 0; f < problem_.factors(); ++f) problem_.updateCost(f);
  }
}

TEST_F(Corrections, GoWhenAVariableIsLinearizedAnew) {
  factor_.correct(problem_, all());
  for (int v = 0; v < problem_.variables(); ++v) {
    problem_.relinearize(v);
    factor_.forget(problem_, v);
  }
  factor_.tree().touchAll();
  ASSERT_FALSE(factor_.factorize(problem_));
  factor_.solve(problem_, 0.0);
  WhitenedFactor model, truth;
  for (int f = 0; f < problem_.factors(); ++f) {
    std::vector<const double*> states;
    for (const int v : problem_.variablesOf(f)) states.push_back(problem_.estimate(v));
    problem_.linearize(f, model);
    whitenedFactor(*problem_.edge(f), states, truth);
    ASSERT_LT((model.e - truth.e).norm(), 1e-9 * (1.0 + truth.e.norm()));
  }
  expectSolved(problem_, factor_);
}

TEST(FrontFactor, AFreeGaugeIsSingular) {
  const CSceneGraph graph =
      generateGraph({.seed = 32, .pose_prior = false, .floor_prior = false}, 20);
  LiveProblem problem;
  for (const auto& edge : graph.edgeSlots()) {
    for (const NodeId node : edge->nodes)
      if (problem.variableOf(node) < 0) problem.addVariable(graph.nodeSlots()[node.value]);
    problem.addFactor(edge);
  }
  CholmodContext context;
  FrontFactor factor;
  factor.build(problem, context);
  EXPECT_TRUE(factor.factorize(problem));
}

}  // namespace
}  // namespace dynemo::test
