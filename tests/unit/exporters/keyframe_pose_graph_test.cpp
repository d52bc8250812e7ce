#include "keyframe_pose_graph.h"

#include <gtest/gtest.h>

#include <random>

#include "small_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-9;

RelativePose randomRelativePose(std::mt19937_64& rng) {
  return {randomPose(rng), Matrix6(randomInformation(6, rng))};
}

TEST(KeyframePoseGraph, InvertedTwiceIsTheSame) {
  std::mt19937_64 rng(1);
  const RelativePose edge = randomRelativePose(rng), twice = inverted(inverted(edge));
  EXPECT_LT(local(edge.T_1_2, twice.T_1_2).norm(), kTolerance);
  EXPECT_LT((edge.information - twice.information).norm(), kTolerance * edge.information.norm());
}

TEST(KeyframePoseGraph, InvertedCostsTheSame) {
  constexpr double kStep = 1e-7, kRelativeTolerance = 1e-5;
  std::mt19937_64 rng(2);
  const RelativePose edge = randomRelativePose(rng), back = inverted(edge);
  const Vector6 d = kStep * (Vector6() << 1, 2, -3, -1, 3, 2).finished();
  const Vector6 d_back = local(back.T_1_2, edge.T_1_2.retract(d).inverse());
  const double expected = d.dot(edge.information * d);
  EXPECT_NEAR(d_back.dot(back.information * d_back), expected, kRelativeTolerance * expected);
}

TEST(KeyframePoseGraph, FusedIsTheWeightedMean) {
  RelativePose a, b;
  b.T_1_2 = Pose3::translation(1.0, 0.0, 0.0);
  b.information = 3.0 * Matrix6::Identity();
  const RelativePose both = fused(a, b);
  EXPECT_NEAR(both.T_1_2.t.x(), 0.75, kTolerance);
  EXPECT_LT((both.information - 4.0 * Matrix6::Identity()).norm(), kTolerance);
}

TEST(KeyframePoseGraph, HoldsKeyframePairsOnly) {
  const SmallRun run = smallRun();
  const auto edges = keyframePoseGraph(run.graph);
  ASSERT_EQ(edges.size(), 2u);
  EXPECT_TRUE(edges.contains({NodeId{0}, NodeId{1}}));
  EXPECT_TRUE(edges.contains({NodeId{1}, NodeId{5}}));
}

}  // namespace
}  // namespace dynemo::test
