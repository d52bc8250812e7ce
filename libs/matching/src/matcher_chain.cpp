#include "dynemo/matching/matcher_chain.h"

#include <cmath>
#include <numbers>
#include <optional>

namespace dynemo {
namespace {

class MatcherChain final : public ScanMatcher {
 public:
  explicit MatcherChain(const MatchingParams& params) : params_(params) {
    for (const std::string& name : params.chain)
      stages_.push_back(scanMatchers().make(name, params));
    if (stages_.empty()) throw ConfigError("matching.chain: names no scan matcher");
  }

  Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const override;

 private:
  std::vector<double> yawStarts_rad(double rotation_sigma_rad) const;
  Expected<ScanMatch, MatchFailure> first(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const;
  MatchRequest refining(const ScanMatch& found) const {
    return {found.T_target_source, params_.refined_translation_sigma_m,
            params_.refined_rotation_sigma_rad};
  }

  MatchingParams params_;
  std::vector<std::unique_ptr<ScanMatcher>> stages_;
};

/// 0, then to either side as far as two standard deviations or half a turn.
std::vector<double> MatcherChain::yawStarts_rad(double rotation_sigma_rad) const {
  std::vector<double> starts = {0.0};
  if (rotation_sigma_rad <= params_.max_single_sigma_rad) return starts;
  const double reach_rad = std::min(2.0 * rotation_sigma_rad, std::numbers::pi);
  for (int k = 1; k * params_.yaw_step_rad <= reach_rad; ++k) {
    starts.push_back(k * params_.yaw_step_rad);
    starts.push_back(-k * params_.yaw_step_rad);
  }
  return starts;
}

/// The first stage from every start; the best fit wins, the earlier one of equals.
Expected<ScanMatch, MatchFailure> MatcherChain::first(const MatchScan& target,
                                                      const MatchScan& source,
                                                      const MatchRequest& request) const {
  const std::vector<double> starts_rad = yawStarts_rad(request.rotation_sigma_rad);
  MatchRequest from = request;
  if (starts_rad.size() > 1) from.rotation_sigma_rad = 0.5 * params_.yaw_step_rad;
  std::optional<Expected<ScanMatch, MatchFailure>> best;
  for (const double yaw_rad : starts_rad) {
    from.T_target_source_guess =
        request.T_target_source_guess * Pose3::fromYawPitchRoll(0, 0, 0, yaw_rad, 0, 0);
    auto found = stages_.front()->match(target, source, from);
    if (!best || (found && (!*best || found->fit() > (*best)->fit()))) best = std::move(found);
  }
  return *best;
}

Expected<ScanMatch, MatchFailure> MatcherChain::match(const MatchScan& target,
                                                      const MatchScan& source,
                                                      const MatchRequest& request) const {
  auto found = first(target, source, request);
  MatchRequest next = found ? refining(*found) : request;
  for (std::size_t i = 1; i < stages_.size(); ++i) {
    found = stages_[i]->match(target, source, next);
    if (found) next = refining(*found);
  }
  return found;
}

}  // namespace

std::unique_ptr<ScanMatcher> makeScanMatcher(const MatchingParams& params) {
  return std::make_unique<MatcherChain>(params);
}

}  // namespace dynemo
