#include "dynemo/core/noise.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "random_values.h"

namespace dynemo::test {
namespace {

TEST(Noise, WhiteningGivesTheMahalanobisNorm) {
  RandomValues random(1);
  for (int n = 1; n <= 6; ++n) {
    const MatrixX omega = random.spd(n);
    const auto U = squareRootInformation(omega);
    ASSERT_TRUE(U);
    VectorX e(n);
    for (double& x : e) x = random.uniform(-1, 1);
    EXPECT_NEAR((*U * e).squaredNorm(), e.dot(omega * e), 1e-12 * e.dot(omega * e));
    EXPECT_NEAR(squaredMahalanobis(e, omega.inverse()), e.dot(omega * e), 1e-9 * e.dot(omega * e));
  }
}

TEST(Noise, MatricesThatAreNoInformationAreRefused) {
  MatrixX asymmetric = MatrixX::Identity(3, 3);
  asymmetric(0, 1) = 0.1;
  MatrixX indefinite = MatrixX::Identity(3, 3);
  indefinite(2, 2) = -1e-3;
  MatrixX nan = MatrixX::Identity(3, 3);
  nan(1, 1) = std::nan("");
  MatrixX infinite = MatrixX::Identity(3, 3);
  infinite(1, 1) = INFINITY;
  for (const MatrixX& bad : {asymmetric, indefinite, nan, infinite, MatrixX(MatrixX::Zero(3, 3)),
                             MatrixX(MatrixX::Ones(3, 3)), MatrixX(MatrixX::Ones(2, 3))}) {
    EXPECT_FALSE(squareRootInformation(bad)) << bad;
    EXPECT_FALSE(invertSpd(bad)) << bad;
  }
}

TEST(Noise, SmallInformationIsStillInformation) {
  EXPECT_TRUE(squareRootInformation(1e-12 * MatrixX::Identity(6, 6)));
  EXPECT_TRUE(squareRootInformation(1e12 * MatrixX::Identity(6, 6)));
}

TEST(Noise, InverseIsSymmetric) {
  RandomValues random(2);
  const MatrixX m = random.spd(6);
  const auto inverse = invertSpd(m);
  ASSERT_TRUE(inverse);
  EXPECT_LT((*inverse * m - MatrixX::Identity(6, 6)).norm(), 1e-10);
  EXPECT_EQ(*inverse, inverse->transpose());
}

TEST(Noise, SingularCovarianceMeansInfinitelyFar) {
  EXPECT_EQ(squaredMahalanobis(VectorX::Ones(2), MatrixX::Zero(2, 2)),
            std::numeric_limits<double>::infinity());
}

TEST(Noise, IsotropicCovarianceHoldsSquares) {
  const Matrix6 cov = isotropicCovariance(0.1, 0.2);
  EXPECT_DOUBLE_EQ(cov(0, 0), 0.1 * 0.1);
  EXPECT_DOUBLE_EQ(cov(5, 5), 0.2 * 0.2);
  EXPECT_EQ(cov(0, 3), 0.0);
}

TEST(Noise, FloorRaisesWhatIsTooCertain) {
  RandomValues random(3);
  for (int i = 0; i < 50; ++i) {
    const Matrix6 cov = 1e-3 * random.spd(6);
    const Matrix6 floored = floorCovariance(cov, 0.05, 0.03);
    const auto least = [](const Matrix3& m) {
      return Eigen::SelfAdjointEigenSolver<Matrix3>(m).eigenvalues()[0];
    };
    EXPECT_GE(least(floored.topLeftCorner<3, 3>()), 0.05 * 0.05 * (1 - 1e-9));
    EXPECT_GE(least(floored.bottomRightCorner<3, 3>()), 0.03 * 0.03 * (1 - 1e-9));
    EXPECT_TRUE(squareRootInformation(floored));
    // It only adds uncertainty.
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6>(floored - cov).eigenvalues()[0], -1e-15);
  }
}

TEST(Noise, FloorLeavesTheUncertainAlone) {
  const Matrix6 cov = isotropicCovariance(0.5, 0.5);
  EXPECT_LT((floorCovariance(cov, 0.05, 0.03) - cov).norm(), 1e-15);
}

TEST(Noise, ChiSquaredQuantilesOfTheTables) {
  EXPECT_NEAR(chiSquaredQuantile(6, 0.99), 16.811894, 1e-5);
  EXPECT_NEAR(chiSquaredQuantile(1, 0.95), 3.841459, 1e-5);
  EXPECT_NEAR(chiSquaredQuantile(3, 0.5), 2.365974, 1e-5);
}

}  // namespace
}  // namespace dynemo::test
