#include "local_start.h"

#include <gtest/gtest.h>

#include "generated_graph.h"
#include "graph_states.h"

namespace dynemo::test {
namespace {

using namespace backend;

/// A solved map of which the newest keyframe has been moved away.
class LocalStarts : public ::testing::Test {
 protected:
  LocalStarts() {
    Optimizer({}).optimizeFully(graph_);
    for (const auto& edge : graph_.edgeSlots()) {
      for (const NodeId node : edge->nodes)
        if (problem_.variableOf(node) < 0) problem_.addVariable(graph_.nodeSlots()[node.value]);
      problem_.addFactor(edge);
    }
    newest_ = problem_.variableOf(graph_.keyframes().back()->id);
    solution_ = stateOf(newest_);
    const Pose3 T = CNodePose::poseFromState(problem_.estimate(newest_));
    std::array<double, CNodePose::kStateSize> moved;
    CNodePose::poseToState(T.retract(Vector6::Constant(0.05)), moved.data());
    problem_.setState(newest_, moved.data());
  }
  std::vector<double> stateOf(int v) const {
    const double* x = problem_.estimate(v);
    return {x, x + problem_.node(v)->stateSize()};
  }
  double costOf(int v) {
    double sum = 0.0;
    problem_.forEachFactorOf(v, [&](int f) {
      problem_.updateCost(f);
      sum += problem_.cost(f);
    });
    return sum;
  }

  CSceneGraph graph_ = generateGraph({.seed = 12, .keyframes_per_lap = 16}, 40);
  LiveProblem problem_;
  int newest_ = -1;
  std::vector<double> solution_;
  SolverParams params_;
};

TEST_F(LocalStarts, BringsANewVariableToWhereItsFactorsWantIt) {
  const double before = costOf(newest_);
  LocalStart(params_).run(problem_, std::vector{newest_});
  const auto state = stateOf(newest_);
  double difference = 0.0;
  for (std::size_t i = 0; i < state.size(); ++i)
    difference = std::max(difference, std::abs(state[i] - solution_[i]));
  EXPECT_LT(difference, 1e-3);
  EXPECT_LT(costOf(newest_), 0.5 * before);
}

TEST_F(LocalStarts, HoldsEverythingElse) {
  std::vector<std::vector<double>> before;
  for (int v = 0; v < problem_.variables(); ++v) before.push_back(stateOf(v));
  LocalStart(params_).run(problem_, std::vector{newest_});
  for (int v = 0; v < problem_.variables(); ++v) {
    if (v != newest_) {
      EXPECT_EQ(stateOf(v), before[v]);
    }
  }
}

TEST_F(LocalStarts, WithoutFactorsThereIsNothingToDo) {
  const auto before = stateOf(newest_);
  std::vector<int> factors;
  problem_.forEachFactorOf(newest_, [&](int f) { factors.push_back(f); });
  for (const int f : factors) problem_.removeFactor(f);
  LocalStart(params_).run(problem_, std::vector{newest_});
  EXPECT_EQ(stateOf(newest_), before);
}

}  // namespace
}  // namespace dynemo::test
