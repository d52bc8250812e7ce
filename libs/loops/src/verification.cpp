#include "dynemo/loops/verification.h"

#include <algorithm>
#include <cstdio>

namespace dynemo {
namespace {

std::string text(const char* what, double value, double limit) {
  char buffer[96];
  std::snprintf(buffer, sizeof(buffer), "%s %.3f (limit %.3f)", what, value, limit);
  return buffer;
}

}  // namespace

PoseEstimate honestEstimate(const ScanMatch& match, double range_m,
                            const ClosureNoiseParams& noise) {
  const Matrix6 scaled = noise.covariance_scale * noise.covariance_scale * match.covariance;
  const double excess_m =
      noise.residual_share * std::max(0.0, match.residual_rms_m - noise.clean_residual_m);
  const double excess_rad = range_m > 0.0 ? excess_m / range_m : 0.0;
  return {match.T_target_source,
          floorCovariance(scaled, noise.min_sigma_m + excess_m, noise.min_sigma_rad + excess_rad)};
}

std::optional<std::string> refusal(const ScanMatch& match, bool entities_agree,
                                   const VerificationParams& params) {
  if (match.inlier_ratio < params.min_inlier_ratio)
    return text("few inliers", match.inlier_ratio, params.min_inlier_ratio);
  if (match.overlap < params.min_overlap)
    return text("little overlap", match.overlap, params.min_overlap);
  if (match.residual_rms_m > params.max_residual_m)
    return text("large residual", match.residual_rms_m, params.max_residual_m);
  if (match.min_eigenvalue < params.min_eigenvalue && !entities_agree)
    return text("degenerate", match.min_eigenvalue, params.min_eigenvalue);
  return std::nullopt;
}

double distanceFromGraph(const PoseEstimate& measured, const PoseEstimate& predicted,
                         double drift_scale) {
  return squaredMahalanobis(
      measured, PoseEstimate{predicted.T, drift_scale * drift_scale * predicted.covariance});
}

}  // namespace dynemo
