#include "pair_information.h"

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
  m.covariance = m.J * jointBlock(covariance, m.at_a, size, m.at_b, size) * m.J.transpose();
  return m;
}

MatrixX sumOf(const std::vector<PairMeasurement>& measurements, const std::vector<MatrixX>& X,
              Eigen::Index n) {
  MatrixX sum = MatrixX::Zero(n, n);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const PairMeasurement& m = measurements[i];
    MatrixX J = MatrixX::Zero(m.J.rows(), n);
    J.middleCols(m.at_a, m.size_a) = m.J.leftCols(m.size_a);
    J.middleCols(m.at_b, m.size_b) = m.J.rightCols(m.size_b);
    sum += J.transpose() * X[i] * J;
  }
  return sum;
}

constexpr double kSlack = 1e-6;

MatrixX inverseOf(const MatrixX& information) {
  const Eigen::Index n = information.rows();
  return (information + kSlack * MatrixX::Identity(n, n)).inverse();
}

/// Of points that one observer sees, each with noise of its own: what is known of their
/// differences.
MatrixX seenFromOnePlace(int points) {
  const auto n = static_cast<double>(points);
  return MatrixX::Identity(points, points) - MatrixX::Constant(points, points, 1.0 / n);
}

TEST(PairInformation, OfATreeItIsWhatIsKnownOfEachPair) {
  std::mt19937_64 rng(5);
  constexpr int kBlocks = 5, kSize = 3;
  const MatrixX covariance = randomInformation(kBlocks * kSize, rng).inverse();
  std::vector<PairMeasurement> tree;
  for (const auto& [a, b] : {std::pair(0, 1), {1, 2}, {1, 3}, {3, 4}})
    tree.push_back(difference(a, b, kSize, covariance));
  const auto X = pairInformation(kBlocks * kSize, tree, kSlack);
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const MatrixX known = tree[i].covariance.inverse();
    EXPECT_LT((X[i] - known).norm(), 0.01 * known.norm()) << i;
  }
}

TEST(PairInformation, AllPairsOfAStarSayAll) {
  constexpr int kPoints = 5;
  const MatrixX information = seenFromOnePlace(kPoints), covariance = inverseOf(information);
  std::vector<PairMeasurement> pairs;
  for (int a = 0; a < kPoints; ++a)
    for (int b = a + 1; b < kPoints; ++b) pairs.push_back(difference(a, b, 1, covariance));
  const auto X = pairInformation(kPoints, pairs, kSlack);
  EXPECT_LT((sumOf(pairs, X, kPoints) - information).norm(), 0.02 * information.norm());
}

TEST(PairInformation, PairsApartAreEachKeptWhole) {
  // Two pairs that have nothing to do with each other, one of them with three points.
  MatrixX information = MatrixX::Zero(5, 5);
  information.topLeftCorner(2, 2) = seenFromOnePlace(2);
  information.bottomRightCorner(3, 3) = seenFromOnePlace(3);
  const MatrixX covariance = inverseOf(information);
  const auto X = pairInformation(5,
                                 {difference(0, 1, 1, covariance), difference(2, 3, 1, covariance),
                                  difference(3, 4, 1, covariance)},
                                 kSlack);
  EXPECT_NEAR(X[0](0, 0), 0.5, 0.01);
  for (const std::size_t i : {1, 2}) EXPECT_NEAR(X[i](0, 0), 0.5, 0.01);
}

TEST(PairInformation, MeasuredPairsAreKnownAsBeforeAndNoneBetter) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr int kBlocks = 4, kSize = 3, kAll = kBlocks * kSize;
    const MatrixX covariance = randomInformation(kAll, rng).inverse();
    std::vector<PairMeasurement> pairs;
    for (int a = 0; a < kBlocks; ++a)
      for (int b = a + 1; b < kBlocks; ++b) pairs.push_back(difference(a, b, kSize, covariance));
    const auto X = pairInformation(kAll, pairs, kSlack);
    const MatrixX left = inverseOf(sumOf(pairs, X, kAll));
    double most = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const PairMeasurement& m = pairs[i];
      const Eigen::SelfAdjointEigenSolver<MatrixX> positive(X[i]);
      EXPECT_GT(positive.eigenvalues().minCoeff(), -1e-9 * X[i].norm());
      // Where a pair has no say of its own, the others may say more than was known.
      const MatrixX after =
          m.J * jointBlock(left, m.at_a, m.size_a, m.at_b, m.size_b) * m.J.transpose();
      const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> ratio(after, m.covariance);
      EXPECT_LT(ratio.eigenvalues().maxCoeff(), 1.05);
      most = std::max(most, X[i].norm());
    }
    EXPECT_GT(most, 0.0);
  }
}

}  // namespace
}  // namespace dynemo::life
