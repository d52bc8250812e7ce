#include "dynemo/loops/pose_estimate.h"

#include <gtest/gtest.h>

#include <random>

#include "dynemo/graph/edge.h"

namespace dynemo {
namespace {

PoseEstimate randomEstimate(std::mt19937_64& rng, double sigma) {
  return {randomPose(rng), sigma * sigma * Matrix6(randomInformation(6, rng))};
}

Vector6 sample(const Matrix6& covariance, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  Vector6 unit;
  for (int i = 0; i < 6; ++i) unit[i] = normal(rng);
  return Matrix6(covariance.llt().matrixL()) * unit;
}

constexpr int kDraws = 20000;
constexpr double kTolerance = 0.05;  // of the largest entry: sampling error of the draws
constexpr double kSmall = 1e-3;      // noise in which everything is linear

template <class Draw>
Matrix6 sampledCovariance(const Pose3& mean, Draw draw) {
  Matrix6 sum = Matrix6::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Vector6 e = local(mean, draw());
    sum += e * e.transpose();
  }
  return sum / kDraws;
}

TEST(PoseEstimate, ComposedCovarianceIsThatOfDraws) {
  std::mt19937_64 rng(7);
  const PoseEstimate a = randomEstimate(rng, kSmall), b = randomEstimate(rng, kSmall);
  const PoseEstimate ab = compose(a, b);
  const Matrix6 sampled = sampledCovariance(ab.T, [&] {
    return a.T.retract(sample(a.covariance, rng)) * b.T.retract(sample(b.covariance, rng));
  });
  EXPECT_LT((sampled - ab.covariance).cwiseAbs().maxCoeff(),
            kTolerance * ab.covariance.cwiseAbs().maxCoeff());
}

TEST(PoseEstimate, InverseCovarianceIsThatOfDraws) {
  std::mt19937_64 rng(8);
  const PoseEstimate a = randomEstimate(rng, kSmall), b = inverse(a);
  const Matrix6 sampled =
      sampledCovariance(b.T, [&] { return a.T.retract(sample(a.covariance, rng)).inverse(); });
  EXPECT_LT((sampled - b.covariance).cwiseAbs().maxCoeff(),
            kTolerance * b.covariance.cwiseAbs().maxCoeff());
}

TEST(PoseEstimate, InvertingTwiceGivesItBack) {
  std::mt19937_64 rng(9);
  const PoseEstimate a = randomEstimate(rng, 0.1), b = inverse(inverse(a));
  EXPECT_LT(local(a.T, b.T).norm(), 1e-12);
  EXPECT_LT((a.covariance - b.covariance).norm(), 1e-9 * a.covariance.norm());
}

TEST(PoseEstimate, FusionOfEqualsHalvesTheVariance) {
  std::mt19937_64 rng(10);
  const PoseEstimate a = randomEstimate(rng, 0.1);
  const auto both = fuse(std::vector<PoseEstimate>{a, a});
  ASSERT_TRUE(both);
  EXPECT_LT(local(a.T, both->T).norm(), 1e-9);
  EXPECT_LT((2.0 * both->covariance - a.covariance).norm(), 1e-9 * a.covariance.norm());
}

TEST(PoseEstimate, FusionFollowsTheMoreCertain) {
  PoseEstimate a{Pose3(), isotropicCovariance(0.01, 0.01)};
  PoseEstimate b{Pose3::translation(0.3, 0, 0), isotropicCovariance(0.03, 0.01)};
  const auto both = fuse(std::vector<PoseEstimate>{a, b});
  ASSERT_TRUE(both);
  EXPECT_NEAR(both->T.t.x(), 0.3 * (0.01 * 0.01) / (0.01 * 0.01 + 0.03 * 0.03), 1e-9);
}

TEST(PoseEstimate, NothingAndTheSingularHaveNoMean) {
  EXPECT_FALSE(fuse({}));
  EXPECT_FALSE(fuse(std::vector<PoseEstimate>{PoseEstimate{}}));
}

TEST(PoseEstimate, LargestSigmaIsThatOfTheWorstDirection) {
  Matrix6 covariance = isotropicCovariance(0.1, 5.0);
  covariance(1, 1) = 0.09;
  EXPECT_NEAR(largestTranslationSigma(covariance), 0.3, 1e-12);
}

}  // namespace
}  // namespace dynemo
