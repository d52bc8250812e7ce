#include "information_shares.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "dynemo/graph/edge.h"

namespace dynemo::life {
namespace {

PairMeasurement difference(int a, int b, int size, const MatrixX& covariance) {
  PairMeasurement m;
  m.at_a = a * size;
  m.at_b = b * size;
  m.size_a = m.size_b = size;
  m.J = MatrixX(size, 2 * size);
  m.J << -MatrixX::Identity(size, size), MatrixX::Identity(size, size);
  MatrixX joint(2 * size, 2 * size);
  joint << covariance.block(m.at_a, m.at_a, size, size),
      covariance.block(m.at_a, m.at_b, size, size), covariance.block(m.at_b, m.at_a, size, size),
      covariance.block(m.at_b, m.at_b, size, size);
  m.information = (m.J * joint * m.J.transpose()).inverse();
  return m;
}

MatrixX sumOf(const std::vector<PairMeasurement>& measurements, const std::vector<double>& shares,
              Eigen::Index n) {
  MatrixX sum = MatrixX::Zero(n, n);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const PairMeasurement& m = measurements[i];
    MatrixX J = MatrixX::Zero(m.J.rows(), n);
    J.middleCols(m.at_a, m.size_a) = m.J.leftCols(m.size_a);
    J.middleCols(m.at_b, m.size_b) = m.J.rightCols(m.size_b);
    sum += shares[i] * J.transpose() * m.information * J;
  }
  return sum;
}

/// Of points that one observer sees, each with noise of its own: what is known of their
/// differences.
MatrixX seenFromOnePlace(int points) {
  const auto n = static_cast<double>(points);
  return MatrixX::Identity(points, points) - MatrixX::Constant(points, points, 1.0 / n);
}

TEST(InformationShares, AMeasurementAloneTakesAll) {
  const MatrixX information = seenFromOnePlace(2);
  const MatrixX covariance = (information + 1e-6 * MatrixX::Identity(2, 2)).inverse();
  const auto shares = informationShares(information, {difference(0, 1, 1, covariance)}, 2e-6);
  ASSERT_EQ(shares.size(), 1u);
  EXPECT_NEAR(shares[0], 1.0, 1e-9);
}

TEST(InformationShares, AllPairsOfAStarShareItExactly) {
  // A star becomes the complete graph with 1/n of the weight: 2/n of each pair's own.
  constexpr int kPoints = 5;
  const MatrixX information = seenFromOnePlace(kPoints);
  const MatrixX covariance = (information + 1e-6 * MatrixX::Identity(kPoints, kPoints)).inverse();
  std::vector<PairMeasurement> pairs;
  for (int a = 0; a < kPoints; ++a)
    for (int b = a + 1; b < kPoints; ++b) pairs.push_back(difference(a, b, 1, covariance));
  const auto shares = informationShares(information, pairs, 2e-6);
  for (const double share : shares) {
    EXPECT_LE(share, 2.0 / kPoints + 1e-4);
    EXPECT_GT(share, 0.65 * 2.0 / kPoints);
  }
}

TEST(InformationShares, IndependentMeasurementsDoNotHoldEachOtherBack) {
  // Two pairs that have nothing to do with each other, one of them with three points.
  MatrixX information = MatrixX::Zero(5, 5);
  information.topLeftCorner(2, 2) = seenFromOnePlace(2);
  information.bottomRightCorner(3, 3) = seenFromOnePlace(3);
  const MatrixX covariance = (information + 1e-6 * MatrixX::Identity(5, 5)).inverse();
  const auto shares =
      informationShares(information,
                        {difference(0, 1, 1, covariance), difference(2, 3, 1, covariance),
                         difference(3, 4, 1, covariance)},
                        2e-6);
  EXPECT_GT(shares[0], 0.95);
  EXPECT_LT(shares[1], 0.7);
  EXPECT_GT(shares[1], 0.3);
}

TEST(InformationShares, TogetherTheyClaimNoMoreThanIsKnown) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr int kBlocks = 4, kSize = 3;
    const MatrixX information = randomInformation(kBlocks * kSize, rng);
    const MatrixX covariance = information.inverse();
    std::vector<PairMeasurement> pairs;
    for (int a = 0; a < kBlocks; ++a)
      for (int b = a + 1; b < kBlocks; ++b) pairs.push_back(difference(a, b, kSize, covariance));
    const auto shares = informationShares(information, pairs, 1e-9);
    const MatrixX rest = information - sumOf(pairs, shares, information.rows());
    const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(rest);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-8);
    EXPECT_GT(*std::max_element(shares.begin(), shares.end()), 0.05);
  }
}

}  // namespace
}  // namespace dynemo::life
