#include "mrpt_icp.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/slam/CICP.h>

#include <mutex>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/matching/assess_match.h"
#include "dynemo/odometry/cell_index.h"

namespace dynemo {
namespace {

/// The first point of each cell.
mrpt::maps::CSimplePointsMap thinned(const SurfacePoints& surface, double leaf_m) {
  mrpt::maps::CSimplePointsMap map;
  CellIndex cells(surface.size());
  const auto inverse_leaf = static_cast<float>(1.0 / leaf_m);
  for (const Eigen::Vector3f& p : surface.points) {
    const std::size_t before = cells.size();
    if (cells.findOrAdd(cellOf(p, inverse_leaf)) == before) map.insertPoint(p.x(), p.y(), p.z());
  }
  return map;
}

class MrptIcp final : public ScanMatcher {
 public:
  explicit MrptIcp(const MatchingParams& params)
      : params_(params.mrpt_icp),
        assessment_(params.assessment),
        min_points_(static_cast<std::size_t>(params.min_points)) {}

  Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const override;

 private:
  mrpt::slam::CICP::TConfigParams options() const;

  MrptIcpParams params_;
  AssessmentParams assessment_;
  std::size_t min_points_;
};

mrpt::slam::CICP::TConfigParams MrptIcp::options() const {
  mrpt::slam::CICP::TConfigParams options;
  options.maxIterations = static_cast<unsigned>(params_.maxIterations);
  options.minAbsStep_trans = params_.minAbsStep_trans;
  options.minAbsStep_rot = params_.minAbsStep_rot;
  options.thresholdDist = params_.thresholdDist;
  options.thresholdAng = params_.thresholdAng;
  options.ALFA = params_.ALFA;
  options.smallestThresholdDist = params_.smallestThresholdDist;
  options.corresponding_points_decimation =
      static_cast<std::uint32_t>(params_.corresponding_points_decimation);
  options.skip_cov_calculation = true;
  return options;
}

Expected<ScanMatch, MatchFailure> MrptIcp::match(const MatchScan& target, const MatchScan& source,
                                                 const MatchRequest& request) const {
  static std::mutex one_at_a_time;
  if (std::min(target.size(), source.size()) < min_points_)
    return make_unexpected(MatchFailure::kTooFewPoints);
  const auto target_map = thinned(target.surface(), params_.leaf_m);
  const auto source_map = thinned(source.surface(), params_.leaf_m);
  mrpt::slam::CICP icp(options());
  mrpt::slam::CICP::TReturnInfo info;
  mrpt::poses::CPose3D found;
  try {
    const std::lock_guard lock(one_at_a_time);
    found = icp.Align3D(&target_map, &source_map, toMrpt(request.T_target_source_guess), info)
                ->getMeanVal();
  } catch (const std::exception&) {
    // MRPT's way to say that the correspondences do not make a pose.
    return make_unexpected(MatchFailure::kNotConverged);
  }
  if (!(info.goodness > 0.0)) return make_unexpected(MatchFailure::kNoOverlap);
  return assessMatch(target, source, fromMrpt(found), static_cast<int>(info.nIterations),
                     assessment_);
}

}  // namespace

std::unique_ptr<ScanMatcher> makeMrptIcp(const MatchingParams& params) {
  return std::make_unique<MrptIcp>(params);
}

}  // namespace dynemo
