#include "pcl_gicp.h"

#include <pcl/registration/gicp.h>

#include "dynemo/matching/assess_match.h"
#include "pcl_points.h"

namespace dynemo {
namespace {

using Gicp = pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;

/// Variance across a surface relative to along it, as PCL's own covariances have it.
constexpr double kThickness = 1e-3;

Gicp::MatricesVectorPtr covariances(const SurfacePoints& surface) {
  Gicp::MatricesVectorPtr all(new Gicp::MatricesVector());
  all->reserve(surface.size());
  for (const Eigen::Vector3f& normal : surface.normals) {
    const Vector3 n = normal.cast<double>();
    all->push_back(Matrix3::Identity() - (1.0 - kThickness) * n * n.transpose());
  }
  return all;
}

class PclGicp final : public ScanMatcher {
 public:
  explicit PclGicp(const MatchingParams& params)
      : params_(params.pcl_gicp),
        assessment_(params.assessment),
        min_points_(static_cast<std::size_t>(params.min_points)) {}

  Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const override;

 private:
  PclGicpParams params_;
  AssessmentParams assessment_;
  std::size_t min_points_;
};

Expected<ScanMatch, MatchFailure> PclGicp::match(const MatchScan& target, const MatchScan& source,
                                                 const MatchRequest& request) const {
  if (std::min(target.size(), source.size()) < min_points_)
    return make_unexpected(MatchFailure::kTooFewPoints);
  Gicp gicp;
  gicp.setMaxCorrespondenceDistance(params_.max_correspondence_m);
  gicp.setMaximumIterations(params_.max_iterations);
  gicp.setTransformationEpsilon(params_.translation_tolerance_m);
  gicp.setRotationEpsilon(params_.rotation_tolerance_rad);
  gicp.setInputTarget(toPcl(target.surface()));
  gicp.setTargetCovariances(covariances(target.surface()));
  gicp.setInputSource(toPcl(source.surface()));
  gicp.setSourceCovariances(covariances(source.surface()));
  const auto T_target_source = align(gicp, request.T_target_source_guess);
  if (!T_target_source) return make_unexpected(T_target_source.error());
  return assessMatch(target, source, *T_target_source, 0, assessment_);
}

}  // namespace

std::unique_ptr<ScanMatcher> makePclGicp(const MatchingParams& params) {
  return std::make_unique<PclGicp>(params);
}

}  // namespace dynemo
