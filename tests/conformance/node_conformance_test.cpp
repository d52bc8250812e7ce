// What every registered node owes the solver: a state that reads back, and a retraction that
// behaves like one.
#include <cmath>
#include <numbers>

#include "registered_types.h"

namespace dynemo::test {
namespace {

constexpr int kSamples = 50;

class Nodes : public ::testing::TestWithParam<NodeType> {
 protected:
  std::mt19937_64 rng_{7};
  double uniform(double a) {
    return a * (2.0 * static_cast<double>(rng_() >> 11) * 0x1.0p-53 - 1.0);
  }
  std::vector<double> randomDelta(const CNodeBase& node, double scale) {
    std::vector<double> delta(static_cast<std::size_t>(node.tangentSize()));
    for (double& d : delta) d = uniform(scale);
    return delta;
  }
  static std::vector<double> stateOf(const CNodeBase& node) {
    std::vector<double> state(static_cast<std::size_t>(node.stateSize()));
    node.readState(state.data());
    return state;
  }
};

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

TEST_P(Nodes, StateWritesBackExactly) {
  for (int i = 0; i < kSamples; ++i) {
    const auto node = GetParam().example(rng_), other = GetParam().example(rng_);
    ASSERT_GT(distance(stateOf(*node), stateOf(*other)), 1e-6);
    other->writeState(stateOf(*node).data());
    EXPECT_EQ(stateOf(*other), stateOf(*node));
    EXPECT_EQ(node->kind(), GetParam().kind);
    EXPECT_LE(node->tangentSize(), kMaxTangent);
  }
}

TEST_P(Nodes, RetractionByZeroStays) {
  const auto node = GetParam().example(rng_);
  const auto state = stateOf(*node);
  const std::vector<double> zero(static_cast<std::size_t>(node->tangentSize()), 0.0);
  std::vector<double> out(state.size());
  node->retract(state.data(), zero.data(), out.data());
  EXPECT_LT(distance(out, state), 1e-14);
}

TEST_P(Nodes, RetractionMayWorkInPlace) {
  for (int i = 0; i < kSamples; ++i) {
    const auto node = GetParam().example(rng_);
    const auto state = stateOf(*node);
    const auto delta = randomDelta(*node, 1.0);
    std::vector<double> out(state.size()), in_place = state;
    node->retract(state.data(), delta.data(), out.data());
    node->retract(in_place.data(), delta.data(), in_place.data());
    EXPECT_EQ(in_place, out);
    EXPECT_EQ(stateOf(*node), state) << "retract must not touch the node's own estimate";
  }
}

TEST_P(Nodes, EveryTangentEntryMovesTheStateAtUnitRate) {
  constexpr double kStep = 1e-6;
  for (int i = 0; i < kSamples; ++i) {
    const auto node = GetParam().example(rng_);
    const auto state = stateOf(*node);
    for (int k = 0; k < node->tangentSize(); ++k) {
      std::vector<double> delta(static_cast<std::size_t>(node->tangentSize()), 0.0),
          plus(state.size()), minus(state.size());
      delta[k] = kStep;
      node->retract(state.data(), delta.data(), plus.data());
      delta[k] = -kStep;
      node->retract(state.data(), delta.data(), minus.data());
      // √2 for a rotation: two columns of the matrix turn.
      const double rate = distance(plus, minus) / (2.0 * kStep);
      EXPECT_TRUE(std::abs(rate - 1.0) < 1e-8 || std::abs(rate - std::numbers::sqrt2) < 1e-8)
          << rate;
    }
  }
}

TEST_P(Nodes, LongChainsOfRetractionsStayOnTheManifold) {
  const auto node = GetParam().example(rng_);
  auto state = stateOf(*node);
  for (int i = 0; i < 20000; ++i) {
    const auto delta = randomDelta(*node, 0.5);
    node->retract(state.data(), delta.data(), state.data());
  }
  node->writeState(state.data());
  if (const auto* pose = dynamic_cast<const CNodePose*>(node.get())) {
    EXPECT_LT((pose->T_map_node.R.transpose() * pose->T_map_node.R - Matrix3::Identity()).norm(),
              1e-13);
    EXPECT_NEAR(pose->T_map_node.R.determinant(), 1.0, 1e-13);
  } else {
    for (const double s : state) EXPECT_TRUE(std::isfinite(s));
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, Nodes, ::testing::ValuesIn(nodeTypes()), KindName());

}  // namespace
}  // namespace dynemo::test
