#include "annealed_gicp.h"

#include <algorithm>

#include "dynemo/core/noise.h"
#include "dynemo/matching/assess_match.h"
#include "dynemo/odometry/registration.h"
#include "dynemo/odometry/worker_pool.h"

namespace dynemo {
namespace {

SurfacePoints everyNth(const SurfacePoints& all, int stride) {
  SurfacePoints some;
  for (std::size_t i = 0; i < all.size(); i += static_cast<std::size_t>(stride)) {
    some.points.push_back(all.points[i]);
    some.normals.push_back(all.normals[i]);
  }
  return some;
}

MatchFailure matchFailureOf(OdometryFailure failure) {
  switch (failure) {
    case OdometryFailure::kTooFewPoints:
      return MatchFailure::kTooFewPoints;
    case OdometryFailure::kNoOverlap:
      return MatchFailure::kNoOverlap;
    default:
      return MatchFailure::kNotConverged;
  }
}

class AnnealedGicp final : public ScanMatcher {
 public:
  explicit AnnealedGicp(const MatchingParams& params)
      : params_(params.annealed_gicp),
        assessment_(params.assessment),
        min_points_(static_cast<std::size_t>(params.min_points)) {}

  Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const override;

 private:
  /// Farthest that a point may be from its partner: three standard deviations of the guess.
  double correspondence_m(const MatchScan& source, const MatchRequest& request) const {
    const double sigma_m =
        request.translation_sigma_m + source.meanRange_m() * request.rotation_sigma_rad;
    return std::min(params_.max_correspondence_m, 3.0 * sigma_m);
  }

  AnnealedGicpParams params_;
  AssessmentParams assessment_;
  std::size_t min_points_;
};

Expected<ScanMatch, MatchFailure> AnnealedGicp::match(const MatchScan& target,
                                                      const MatchScan& source,
                                                      const MatchRequest& request) const {
  if (std::min(target.size(), source.size()) < min_points_)
    return make_unexpected(MatchFailure::kTooFewPoints);
  WorkerPool here(1);
  RegistrationPrior prior;
  prior.T_target_base = request.T_target_source_guess;
  prior.covariance = isotropicCovariance(request.translation_sigma_m, request.rotation_sigma_rad);
  prior.correspondence_m = correspondence_m(source, request);
  int iterations = 0;
  if (prior.correspondence_m > params_.fine_correspondence_m) {
    const auto coarse = registerScan(everyNth(source.surface(), params_.coarse_stride),
                                     target.target(), prior, params_.coarse, here);
    if (!coarse) return make_unexpected(matchFailureOf(coarse.error()));
    prior.T_target_base = coarse->T_target_base;
    prior.correspondence_m = params_.fine_correspondence_m;
    iterations = coarse->diagnostics.iterations;
  }
  const auto fine = registerScan(source.surface(), target.target(), prior, params_.fine, here);
  if (!fine) return make_unexpected(matchFailureOf(fine.error()));
  return assessMatch(target, source, fine->T_target_base, iterations + fine->diagnostics.iterations,
                     assessment_);
}

}  // namespace

std::unique_ptr<ScanMatcher> makeAnnealedGicp(const MatchingParams& params) {
  return std::make_unique<AnnealedGicp>(params);
}

}  // namespace dynemo
