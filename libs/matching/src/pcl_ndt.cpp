#include "pcl_ndt.h"

#include <pcl/registration/ndt.h>

#include "dynemo/matching/assess_match.h"
#include "pcl_points.h"

namespace dynemo {
namespace {

using Ndt = pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ>;

class PclNdt final : public ScanMatcher {
 public:
  explicit PclNdt(const MatchingParams& params)
      : params_(params.pcl_ndt),
        assessment_(params.assessment),
        min_points_(static_cast<std::size_t>(params.min_points)) {}

  Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const override;

 private:
  PclNdtParams params_;
  AssessmentParams assessment_;
  std::size_t min_points_;
};

Expected<ScanMatch, MatchFailure> PclNdt::match(const MatchScan& target, const MatchScan& source,
                                                const MatchRequest& request) const {
  if (std::min(target.size(), source.size()) < min_points_)
    return make_unexpected(MatchFailure::kTooFewPoints);
  Ndt ndt;
  // The target's cells are made from the resolution at hand when the target is set.
  ndt.setResolution(static_cast<float>(params_.resolution_m));
  ndt.setInputTarget(toPcl(target.surface()));
  ndt.setInputSource(toPcl(source.surface()));
  ndt.setStepSize(params_.step_m);
  ndt.setOulierRatio(params_.outlier_ratio);
  ndt.setTransformationEpsilon(params_.tolerance);
  ndt.setMaximumIterations(params_.max_iterations);
  const auto T_target_source = align(ndt, request.T_target_source_guess);
  if (!T_target_source) return make_unexpected(T_target_source.error());
  return assessMatch(target, source, *T_target_source, ndt.getFinalNumIteration(), assessment_);
}

}  // namespace

std::unique_ptr<ScanMatcher> makePclNdt(const MatchingParams& params) {
  return std::make_unique<PclNdt>(params);
}

}  // namespace dynemo
