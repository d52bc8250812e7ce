#include "dynemo/loops/verification.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

ScanMatch goodMatch() {
  ScanMatch match;
  match.T_target_source = Pose3::fromYawPitchRoll(1, 2, 0, 0.5, 0, 0);
  match.covariance = isotropicCovariance(0.001, 0.0005);
  match.overlap = 0.9;
  match.inlier_ratio = 0.9;
  match.residual_rms_m = 0.01;
  match.min_eigenvalue = 0.1;
  return match;
}

TEST(Refusal, AGoodMatchHasNone) { EXPECT_FALSE(refusal(goodMatch(), false, {})); }

TEST(Refusal, EachFigureHasItsGate) {
  const VerificationParams params;
  ScanMatch match = goodMatch();
  match.inlier_ratio = 0.9 * params.min_inlier_ratio;
  EXPECT_EQ(refusal(match, true, params)->substr(0, 11), "few inliers");
  match = goodMatch();
  match.overlap = 0.9 * params.min_overlap;
  EXPECT_EQ(refusal(match, true, params)->substr(0, 14), "little overlap");
  match = goodMatch();
  match.residual_rms_m = 1.1 * params.max_residual_m;
  EXPECT_EQ(refusal(match, true, params)->substr(0, 14), "large residual");
  match = goodMatch();
  match.min_eigenvalue = 0.9 * params.min_eigenvalue;
  EXPECT_EQ(refusal(match, false, params)->substr(0, 10), "degenerate");
}

TEST(Refusal, EntitiesVouchForADegenerateMatch) {
  ScanMatch match = goodMatch();
  match.min_eigenvalue = 0.0;
  EXPECT_TRUE(refusal(match, false, {}));
  EXPECT_FALSE(refusal(match, true, {}));
}

TEST(HonestEstimate, ScalesAndFloorsTheCovariance) {
  ClosureNoiseParams noise;
  noise.covariance_scale = 3.0;
  noise.min_sigma_m = 0.01;
  noise.min_sigma_rad = 0.001;
  ScanMatch match = goodMatch();
  match.covariance(0, 0) = 0.02 * 0.02;
  noise.residual_share = 0.0;
  const PoseEstimate estimate = honestEstimate(match, 5.0, noise);
  EXPECT_NEAR(std::sqrt(estimate.covariance(0, 0)), 0.06, 1e-9);
  EXPECT_NEAR(std::sqrt(estimate.covariance(1, 1)), 0.01, 1e-9);
  EXPECT_NEAR(std::sqrt(estimate.covariance(5, 5)), 0.0015, 1e-9);
  EXPECT_LT(local(estimate.T, match.T_target_source).norm(), 1e-12);
}

TEST(HonestEstimate, GrowsWithTheResidual) {
  ClosureNoiseParams noise;
  noise.min_sigma_m = noise.min_sigma_rad = 1e-3;
  noise.clean_residual_m = 0.01;
  noise.residual_share = 2.0;
  ScanMatch match = goodMatch();
  match.residual_rms_m = 0.05;
  const PoseEstimate estimate = honestEstimate(match, 5.0, noise);
  EXPECT_NEAR(std::sqrt(estimate.covariance(0, 0)), 0.081, 1e-9);
  EXPECT_NEAR(std::sqrt(estimate.covariance(5, 5)), 0.017, 1e-9);
}

TEST(DistanceFromGraph, CountsBothUncertainties) {
  const PoseEstimate measured{Pose3::translation(0.5, 0, 0), isotropicCovariance(0.3, 0.1)};
  const PoseEstimate predicted{Pose3(), isotropicCovariance(0.2, 0.1)};
  EXPECT_NEAR(distanceFromGraph(measured, predicted, 1.0), 0.25 / (0.09 + 0.04), 1e-9);
  EXPECT_NEAR(distanceFromGraph(measured, predicted, 2.0), 0.25 / (0.09 + 0.16), 1e-9);
}

}  // namespace
}  // namespace dynemo
