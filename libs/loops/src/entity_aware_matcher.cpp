#include "dynemo/loops/entity_aware_matcher.h"

#include <cmath>

#include "dynemo/loops/verification.h"
#include "dynemo/matching/assess_match.h"

namespace dynemo {
namespace {

/// A few hundred kilobytes each.
constexpr std::size_t kCachedScans = 100;

MatchRequest requestFor(const PoseEstimate& seed, double sigma_factor) {
  MatchRequest request;
  request.T_target_source_guess = seed.T;
  request.translation_sigma_m = sigma_factor * largestTranslationSigma(seed.covariance);
  request.rotation_sigma_rad =
      sigma_factor * std::sqrt(seed.covariance.diagonal().tail<3>().maxCoeff());
  return request;
}

bool leaveOutTheSame(const FilteredPair& a, const FilteredPair& b) {
  return a.removed_earlier == b.removed_earlier && a.removed_later == b.removed_later;
}

}  // namespace

EntityAwareMatcher::EntityAwareMatcher(const LoopParams& params,
                                       std::unique_ptr<ScanMatcher> matcher)
    : params_(params),
      prefilter_(entityPrefilters().make(params.prefilter.method, params.prefilter)),
      matcher_(std::move(matcher)),
      scans_(params.matching.scan, kCachedScans) {}

EntityAwareMatch EntityAwareMatcher::match(const CSceneGraph& graph, const LoopPair& pair,
                                           const PoseEstimate& seed) {
  EntityAwareMatch first = matchWithout(prefilter_->filter(graph, pair, seed), pair, seed);
  if (!first.match) return first;
  const PoseEstimate measured = honestEstimate(*first.match, first.range_m, params_.noise);
  FilteredPair filtered = prefilter_->filter(graph, pair, measured);
  if (leaveOutTheSame(filtered, first.filtered)) return first;
  EntityAwareMatch second = matchWithout(std::move(filtered), pair, measured);
  if (!second.match) return first;
  second.seed_inlier_ratio = first.seed_inlier_ratio;
  return second;
}

EntityAwareMatch EntityAwareMatcher::matchWithout(FilteredPair filtered, const LoopPair& pair,
                                                  const PoseEstimate& seed) {
  const MatchScan target =
      scans_.get(*pair.earlier).without(*pair.earlier->scan, filtered.removed_earlier);
  const MatchScan source =
      scans_.get(*pair.later).without(*pair.later->scan, filtered.removed_later);
  const auto at_seed = assessMatch(target, source, seed.T, 0, params_.matching.assessment);
  return {std::move(filtered), source.meanRange_m(),
          at_seed ? std::optional(at_seed->inlier_ratio) : std::nullopt,
          matcher_->match(target, source, requestFor(seed, params_.verification.drift_scale))};
}

}  // namespace dynemo
