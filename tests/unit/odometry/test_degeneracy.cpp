#include "dynemo/odometry/degeneracy.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

TEST(Degeneracy, FindsTheWeakDirectionAndProjectsItAway) {
  const Vector6 weak = (Vector6() << 0.6, 0, 0, 0, 0.8, 0).finished();
  const Matrix6 H =
      0.3 * (Matrix6::Identity() - weak * weak.transpose()) + 0.001 * weak * weak.transpose();
  const Degeneracy found = findDegeneracy(H, 0.01);
  ASSERT_EQ(found.directions.cols(), 1);
  EXPECT_NEAR(std::abs(found.directions.col(0).dot(weak)), 1.0, 1e-12);
  EXPECT_LT((found.projector * weak).norm(), 1e-12);
  EXPECT_NEAR(found.projector.trace(), 5.0, 1e-12);
}

TEST(Degeneracy, NothingIsWeakInAWellConstrainedProblem) {
  const Degeneracy found = findDegeneracy(0.2 * Matrix6::Identity(), 0.01);
  EXPECT_FALSE(found.any());
  EXPECT_TRUE(found.projector.isIdentity(1e-15));
}

TEST(Degeneracy, TellsTheSmallestShareAndCanBeSwitchedOff) {
  const Matrix6 H = (Vector6() << 0.3, 0.2, -0.001, 0.3, 0.4, 0.5).finished().asDiagonal();
  EXPECT_NEAR(findDegeneracy(H, 0.01).smallest_share, -0.001, 1e-15);
  EXPECT_EQ(findDegeneracy(H, 0.01).directions.cols(), 1);
  EXPECT_FALSE(findDegeneracy(H, 0.0).any());
}

TEST(Degeneracy, NoInformationLeavesNoDirectionObserved) {
  EXPECT_EQ(findDegeneracy(Matrix6::Zero(), 0.01).directions.cols(), 6);
}

}  // namespace
}  // namespace dynemo
