// Scan matchers on recorded pairs of other people; DYNEMO_REAL_DATA names their folder.
#include "registration_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "dynemo/matching/matcher_chain.h"
#include "sample_dataset.h"

namespace dynemo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<std::string> allMatchers() {
  std::vector<std::string> names = scanMatchers().names();
  names.push_back("chain");
  return names;
}

class RealPairs : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto data = test::realDataFolder();
    if (!data) GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
    folder_ = *data / "registration";
    matcher_ =
        GetParam() == "chain" ? makeScanMatcher(params_) : scanMatchers().make(GetParam(), params_);
  }
  /// Point to point and point to distribution do not claim centimetres: they must come near enough
  /// to be refined.
  bool coarse() const { return GetParam() == "mrpt_icp" || GetParam() == "pcl_ndt"; }
  void expectNear(const Expected<ScanMatch, MatchFailure>& found, const Pose3& T_expected,
                  double translation_m, double rotation_rad) const {
    ASSERT_TRUE(found) << toString(found.error());
    const Vector6 error = local(T_expected, found->T_target_source);
    std::printf("  %-14s %5.1f mm %.3f deg, overlap %.2f inliers %.2f\n", GetParam().c_str(),
                1e3 * error.head<3>().norm(), error.tail<3>().norm() / kDegree, found->overlap,
                found->inlier_ratio);
    EXPECT_LT(error.head<3>().norm(), coarse() ? 0.3 : translation_m);
    EXPECT_LT(error.tail<3>().norm(), coarse() ? 2.0 * kDegree : rotation_rad);
  }

  std::filesystem::path folder_;
  MatchingParams params_;
  std::unique_ptr<ScanMatcher> matcher_;
};

Pose3 disturbed(const Pose3& T, double translation_m, double rotation_rad,
                std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Vector3(normal(random), normal(random), normal(random)).normalized();
  };
  Vector6 d;
  d << translation_m * direction(), rotation_rad * direction();
  return T.retract(d);
}

TEST_P(RealPairs, OutdoorCarScansFromHalfAMetreAndTenDegrees) {
  if (GetParam() == "pcl_ndt") GTEST_SKIP() << "cells of 1 m do not reach that far";
  Pose3 T_target_source;
  const auto pair = test::readSmallGicpPair(folder_, T_target_source);
  const MatchScan target(pair.target, params_.scan), source(pair.source, params_.scan);
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 5; ++trial) {
    const MatchRequest request{disturbed(T_target_source, 0.5, 10 * kDegree, random), 0.3,
                               6 * kDegree};
    const auto found = matcher_->match(target, source, request);
    expectNear(found, T_target_source, 0.05, 0.5 * kDegree);
  }
}

TEST_P(RealPairs, ApartmentFromIdentity) {
  const auto pair = test::readApartmentPair(folder_);
  Matrix3 R;
  R << .993552, -.113149, .007131, .113181, .993565, -.004260, -.006603, .005040, .999965;
  const Pose3 T_target_source(nearestRotation(R), {.60831, -.003878, .010727});
  const auto found = matcher_->match({pair.target, params_.scan}, {pair.source, params_.scan},
                                     {Pose3(), 0.5, 0.1});
  expectNear(found, T_target_source, 0.03, 1.0 * kDegree);
}

/// Median distance from the source's points to the target's nearest, both at `leaf_m`.
double medianDistance_m(const test::RegistrationPair& pair, const Pose3& T_target_source,
                        double leaf_m) {
  SurfaceParams dense;
  dense.leaf_m = leaf_m;
  dense.max_flatness = 1.0;
  const MatchScan target(pair.target, dense), source(pair.source, dense);
  std::vector<double> distances_m;
  for (const Eigen::Vector3f& p : source.surface().points) {
    const Eigen::Vector3f q = (T_target_source * p.cast<double>()).cast<float>();
    Correspondence nearest;
    const bool found =
        target.target().nearest(q, Eigen::Vector3f::UnitZ(), {100.0F, -1.0F, false}, nearest);
    distances_m.push_back(found ? static_cast<double>((nearest.point - q).norm()) : 100.0);
  }
  const auto middle = distances_m.begin() + static_cast<std::ptrdiff_t>(distances_m.size() / 2);
  std::nth_element(distances_m.begin(), middle, distances_m.end());
  return *middle;
}

TEST_P(RealPairs, RoomFromTheGivenGuess) {
  const auto pair = test::readPclRoomPair(folder_);
  const Pose3 T_guess = Pose3::fromYawPitchRoll(1.79387, 0.720047, 0, 0.6931, 0, 0);
  const auto found = matcher_->match({pair.target, params_.scan}, {pair.source, params_.scan},
                                     {T_guess, 0.5, 0.1});
  ASSERT_TRUE(found) << toString(found.error());
  const double median_m = medianDistance_m(pair, found->T_target_source, 0.1);
  std::printf("  %-14s median %.1f mm (guess %.1f mm)\n", GetParam().c_str(), 1e3 * median_m,
              1e3 * medianDistance_m(pair, T_guess, 0.1));
  EXPECT_LT(median_m, 0.10);
}

INSTANTIATE_TEST_SUITE_P(Registry, RealPairs, ::testing::ValuesIn(allMatchers()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace dynemo
