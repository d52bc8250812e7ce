#include "dynemo/matching/assess_match.h"

#include <algorithm>

#include "dynemo/odometry/registration.h"
#include "dynemo/odometry/worker_pool.h"

namespace dynemo {
namespace {

RegistrationParams strictly(const AssessmentParams& params) {
  RegistrationParams strict;
  strict.min_correspondence_m = params.overlap_m;
  strict.kernel_m = params.inlier_m;
  strict.min_residual_m = params.min_residual_m;
  strict.min_observed_share = params.min_eigenvalue;
  return strict;
}

double contradiction(const MatchScan& target, const MatchScan& source,
                     const Pose3& T_target_source) {
  return std::max(
      target.seenSpace().contradicted(source.surface().points, T_target_source),
      source.seenSpace().contradicted(target.surface().points, T_target_source.inverse()));
}

}  // namespace

Expected<ScanMatch, MatchFailure> assessMatch(const MatchScan& target, const MatchScan& source,
                                              const Pose3& T_target_source, int iterations,
                                              const AssessmentParams& params) {
  if (!T_target_source.isFinite()) return make_unexpected(MatchFailure::kNotConverged);
  RegistrationPrior at;
  at.T_target_base = T_target_source;
  WorkerPool here(1);
  const auto found =
      assessRegistration(source.surface(), target.target(), at, strictly(params), here);
  if (!found) return make_unexpected(MatchFailure::kNoOverlap);
  const OdometryDiagnostics& d = found->diagnostics;
  if (d.overlap < params.min_overlap) return make_unexpected(MatchFailure::kNoOverlap);
  ScanMatch match;
  match.contradiction = contradiction(target, source, T_target_source);
  if (match.contradiction > params.max_contradiction)
    return make_unexpected(MatchFailure::kContradicted);
  if (d.degenerate_directions.cols() > 0) return make_unexpected(MatchFailure::kDegenerate);
  match.T_target_source = T_target_source;
  match.covariance = found->covariance.topLeftCorner<6, 6>();
  match.overlap = d.overlap;
  match.inlier_ratio = d.inlier_ratio / d.overlap;
  match.residual_rms_m = d.residual_rms_m;
  match.min_eigenvalue = d.smallest_share;
  match.iterations = iterations;
  return match;
}

}  // namespace dynemo
