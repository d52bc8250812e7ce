#include "dynemo/loops/odometry_chain.h"

#include <gtest/gtest.h>

#include <limits>

#include "loop_graph.h"

namespace dynemo {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();

class OdometryChains : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 10; ++i) drive_.addKeyframe();
    chain_.extend(drive_.graph);
  }
  Pose3 odometry(std::size_t k) const { return drive_.graph.keyframes()[k]->T_odom_base; }

  test::LoopGraph drive_;
  OdometryChain chain_;
};

TEST_F(OdometryChains, IsTheOdometryBetweenAnyTwo) {
  for (const auto& [a, b] : {std::pair(2, 7), std::pair(7, 2), std::pair(4, 4)}) {
    const auto T_a_b = chain_.between(a, b, kAny);
    ASSERT_TRUE(T_a_b);
    EXPECT_LT(local(odometry(a).inverse() * odometry(b), T_a_b->T).norm(), 1e-9);
  }
}

TEST_F(OdometryChains, BackwardsTheCovarianceIsThatOfTheInverse) {
  const auto forward = chain_.between(2, 7, kAny), backward = chain_.between(7, 2, kAny);
  EXPECT_LT((inverse(*forward).covariance - backward->covariance).norm(), 1e-12);
}

TEST_F(OdometryChains, CovarianceIsTheGraphsOwn) {
  // Without closures the marginals of the graph are those of the chain.
  drive_.optimize();
  const auto chain = chain_.between(3, 9, kAny);
  const auto& keyframes = drive_.graph.keyframes();
  const auto joint = drive_.optimizer.marginalCovariance(
      drive_.graph, std::vector<NodeId>{keyframes[3]->id, keyframes[9]->id});
  ASSERT_TRUE(joint);
  Eigen::Matrix<double, 6, 12> J;
  J << -composeJacobianLeft(chain->T), Matrix6::Identity();
  EXPECT_LT((J * *joint * J.transpose() - chain->covariance).norm(),
            1e-6 * chain->covariance.norm());
}

TEST_F(OdometryChains, StopsWhereItGetsTooUncertain) {
  EXPECT_TRUE(chain_.between(2, 4, 0.1));
  EXPECT_FALSE(chain_.between(2, 9, 0.03));
}

TEST_F(OdometryChains, PathGrowsWithNewKeyframes) {
  const double before_m = chain_.path_m(9);
  drive_.addKeyframe();
  chain_.extend(drive_.graph);
  ASSERT_EQ(chain_.size(), 11u);
  EXPECT_NEAR(chain_.path_m(10) - before_m, 1.0, 0.1);
  EXPECT_EQ(chain_.pathBetween_m(3, 8), chain_.pathBetween_m(8, 3));
}

TEST_F(OdometryChains, AKeyframeThatLeavesLeavesItsPathAndItsOdometry) {
  const auto before = chain_.between(2, 9, kAny);
  const double path_m = chain_.pathBetween_m(2, 9);
  ASSERT_TRUE(before);
  const std::size_t keyframes = chain_.size();
  chain_.remove(5);
  ASSERT_EQ(chain_.size(), keyframes - 1);
  const auto after = chain_.between(2, 8, kAny);
  ASSERT_TRUE(after);
  EXPECT_LT(local(before->T, after->T).norm(), 1e-9);
  EXPECT_LT((before->covariance - after->covariance).norm(), 1e-6 * before->covariance.norm());
  EXPECT_DOUBLE_EQ(chain_.pathBetween_m(2, 8), path_m);
  EXPECT_THROW(chain_.remove(keyframes), std::out_of_range);
}

}  // namespace
}  // namespace dynemo
