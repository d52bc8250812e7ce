// What every registered matcher and the default chain keep to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "dynemo/matching/matcher_chain.h"
#include "scan_pair.h"

namespace dynemo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

const std::string kChain = "default chain";

std::vector<std::string> allMatchers() {
  std::vector<std::string> names = scanMatchers().names();
  names.push_back(kChain);
  return names;
}

class AllMatchers : public ::testing::TestWithParam<std::string> {
 protected:
  AllMatchers() {
    matcher_ =
        GetParam() == kChain ? makeScanMatcher(params_) : scanMatchers().make(GetParam(), params_);
  }
  MatchScan prepared(const Scan& scan) const { return {scan, params_.scan}; }
  Expected<ScanMatch, MatchFailure> match(const Scan& target, const Scan& source,
                                          const Pose3& T_guess) const {
    return matcher_->match(prepared(target), prepared(source), {T_guess, 0.1, 0.05});
  }

  /// Point to point and point to distribution are coarse.
  bool coarse() const { return GetParam() == "mrpt_icp" || GetParam() == "pcl_ndt"; }
  void expectNear(const Expected<ScanMatch, MatchFailure>& found, const Pose3& T_expected) const {
    ASSERT_TRUE(found) << toString(found.error());
    const Vector6 error = local(T_expected, found->T_target_source);
    EXPECT_LT(error.head<3>().norm(), coarse() ? 0.12 : 0.01);
    EXPECT_LT(error.tail<3>().norm(), (coarse() ? 2.0 : 0.2) * kDegree);
  }

  MatchingParams params_;
  std::unique_ptr<ScanMatcher> matcher_;
};

TEST_P(AllMatchers, FindTheRelativePose) {
  const test::ScanPair pair = test::roomPair();
  const auto found =
      match(pair.target, pair.source, test::disturbed(pair.T_target_source, 0.15, 3 * kDegree));
  expectNear(found, pair.T_target_source);
  EXPECT_GT(found->overlap, 0.5);
  EXPECT_LE(found->overlap, 1.0);
  EXPECT_GT(found->inlier_ratio, coarse() ? 0.4 : 0.9);
  EXPECT_LE(found->inlier_ratio, 1.0);
  EXPECT_LT(found->residual_rms_m, 0.05);
  EXPECT_GT(found->min_eigenvalue, 0.01);
}

TEST_P(AllMatchers, FindTheInverseWhenScansAreSwapped) {
  const test::ScanPair pair = test::roomPair();
  const Pose3 T_source_target = pair.T_target_source.inverse();
  expectNear(match(pair.source, pair.target, test::disturbed(T_source_target, 0.15, 3 * kDegree)),
             T_source_target);
}

TEST_P(AllMatchers, FollowTheTargetFrame) {
  test::ScanPair pair = test::roomPair();
  const Pose3 T_shifted_target = Pose3::fromYawPitchRoll(0.4, -0.3, 0.2, 0.5, 0, 0);
  pair.target.T_base_lidar = T_shifted_target * pair.target.T_base_lidar;
  const Pose3 T_shifted_source = T_shifted_target * pair.T_target_source;
  expectNear(match(pair.target, pair.source, test::disturbed(T_shifted_source, 0.15, 3 * kDegree)),
             T_shifted_source);
}

TEST_P(AllMatchers, GiveTheSameBytesTwice) {
  const test::ScanPair pair = test::roomPair();
  const Pose3 T_guess = test::disturbed(pair.T_target_source, 0.15, 3 * kDegree);
  const auto a = match(pair.target, pair.source, T_guess);
  const auto b = match(pair.target, pair.source, T_guess);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->T_target_source.R, b->T_target_source.R);
  EXPECT_EQ(a->T_target_source.t, b->T_target_source.t);
  EXPECT_EQ(a->covariance, b->covariance);
  EXPECT_EQ(a->inlier_ratio, b->inlier_ratio);
}

TEST_P(AllMatchers, ReportACorridorAsDegenerate) {
  const test::ScanPair pair = test::corridorPair();
  const auto found = match(pair.target, pair.source, pair.T_target_source);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error(), MatchFailure::kDegenerate);
}

TEST_P(AllMatchers, ReportScansThatAreTooSmall) {
  const test::ScanPair pair = test::roomPair();
  Scan tiny = pair.source;
  tiny.cloud.points.resize(50);
  Scan empty{pair.source.stamp, {}, pair.source.T_base_lidar};
  for (const Scan* few : {&tiny, &empty}) {
    for (const auto& found : {match(pair.target, *few, Pose3()), match(*few, pair.source, Pose3()),
                              match(*few, *few, Pose3())}) {
      ASSERT_FALSE(found);
      EXPECT_EQ(found.error(), MatchFailure::kTooFewPoints);
    }
  }
}

TEST_P(AllMatchers, FindNothingFarAway) {
  const test::ScanPair pair = test::roomPair();
  const auto found = match(pair.target, pair.source, Pose3::translation(200, 0, 0));
  ASSERT_FALSE(found);
  EXPECT_NE(found.error(), MatchFailure::kTooFewPoints);
}

TEST_P(AllMatchers, SkipPointsThatAreNoNumbers) {
  test::ScanPair pair = test::roomPair();
  const Pose3 T_guess = test::disturbed(pair.T_target_source, 0.15, 3 * kDegree);
  const auto clean = match(pair.target, pair.source, T_guess);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (Scan* scan : {&pair.target, &pair.source}) {
    scan->cloud.points.insert(scan->cloud.points.begin() + 100, {kNan, 1.0F, 2.0F});
    scan->cloud.points.push_back({kNan, kNan, kNan});
  }
  const auto found = match(pair.target, pair.source, T_guess);
  ASSERT_TRUE(clean && found);
  EXPECT_EQ(found->T_target_source.t, clean->T_target_source.t);
}

INSTANTIATE_TEST_SUITE_P(Registry, AllMatchers, ::testing::ValuesIn(allMatchers()),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

}  // namespace
}  // namespace dynemo
