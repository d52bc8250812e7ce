#include "dynemo/matching/matcher_chain.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>

#include "scan_pair.h"

namespace dynemo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Prepared {
  explicit Prepared(const test::ScanPair& pair)
      : target(pair.target, MatchingParams().scan), source(pair.source, MatchingParams().scan) {}
  MatchScan target, source;
};

TEST(MatcherChain, RefinesToMillimetresFromAPoorGuess) {
  const test::ScanPair pair = test::roomPair();
  const Prepared scans(pair);
  const auto found = makeScanMatcher({})->match(
      scans.target, scans.source,
      {test::disturbed(pair.T_target_source, 1.0, 15 * kDegree), 0.5, 0.15});
  ASSERT_TRUE(found) << toString(found.error());
  const Vector6 error = local(pair.T_target_source, found->T_target_source);
  EXPECT_LT(error.head<3>().norm(), 0.005);
  EXPECT_LT(error.tail<3>().norm(), 0.1 * kDegree);
}

TEST(MatcherChain, CovarianceIsOfTheErrorsSize) {
  const test::ScanPair pair = test::roomPair();
  const Prepared scans(pair);
  const auto found =
      makeScanMatcher({})->match(scans.target, scans.source, {pair.T_target_source, 0.1, 0.05});
  ASSERT_TRUE(found);
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(found->covariance);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(std::sqrt(solver.eigenvalues().maxCoeff()), 0.01);
}

/// The guess is turned by more than any single start recovers.
TEST(MatcherChain, StartsAtSeveralYawAnglesWhenTheRotationIsUncertain) {
  const test::ScanPair pair = test::roomPair();
  const Prepared scans(pair);
  const Pose3 T_guess =
      pair.T_target_source * Pose3::fromYawPitchRoll(0, 0, 0, 130 * kDegree, 0, 0);
  const auto matcher = makeScanMatcher({});
  const auto narrow = matcher->match(scans.target, scans.source, {T_guess, 0.3, 0.1});
  EXPECT_FALSE(narrow && rotationAngle(pair.T_target_source.inverse() * narrow->T_target_source) <
                             1 * kDegree);
  const auto wide = matcher->match(scans.target, scans.source, {T_guess, 0.3, 2.0});
  ASSERT_TRUE(wide) << toString(wide.error());
  const Vector6 error = local(pair.T_target_source, wide->T_target_source);
  EXPECT_LT(error.head<3>().norm(), 0.005);
  EXPECT_LT(error.tail<3>().norm(), 0.1 * kDegree);
}

TEST(MatcherChain, GoesOnWhereTheCoarseMatcherFindsNothing) {
  const test::ScanPair pair = test::roomPair();
  const Prepared scans(pair);
  MatchingParams params;
  params.mrpt_icp.thresholdDist = params.mrpt_icp.smallestThresholdDist = 1e-4;
  const MatchRequest request{test::disturbed(pair.T_target_source, 0.1, 1 * kDegree), 0.1, 0.05};
  ASSERT_FALSE(scanMatchers().make("mrpt_icp", params)->match(scans.target, scans.source, request));
  const auto found = makeScanMatcher(params)->match(scans.target, scans.source, request);
  ASSERT_TRUE(found);
  EXPECT_LT(local(pair.T_target_source, found->T_target_source).head<3>().norm(), 0.005);
}

TEST(MatcherChain, NamesItsMatchers) {
  MatchingParams params;
  params.chain = {"mrpt_icp", "loam"};
  EXPECT_THROW(makeScanMatcher(params), ConfigError);
  params.chain.clear();
  EXPECT_THROW(makeScanMatcher(params), ConfigError);
}

}  // namespace
}  // namespace dynemo
