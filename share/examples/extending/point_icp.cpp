// A scan matcher: point-to-point ICP in closed form (Umeyama, 1991).
#include "point_icp.h"

#include <algorithm>

#include "dynemo/matching/assess_match.h"

namespace dynemo {
namespace {

constexpr int kMaxIterations = 200;
constexpr double kConverged_m = 1e-4;

class PointIcp final : public ScanMatcher {
 public:
  explicit PointIcp(const MatchingParams& params) : params_(params) {}

  Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                          const MatchRequest& request) const override {
    const auto min_points = static_cast<std::size_t>(params_.min_points);
    if (std::min(target.size(), source.size()) < min_points)
      return make_unexpected(MatchFailure::kTooFewPoints);
    Pose3 T_target_source = request.T_target_source_guess;
    for (int i = 1; i <= kMaxIterations; ++i) {
      const auto moved = step(target, source, T_target_source);
      if (!moved) return make_unexpected(MatchFailure::kNoOverlap);
      const double change_m = (moved->t - T_target_source.t).norm();
      T_target_source = *moved;
      if (change_m < kConverged_m)
        return assessMatch(target, source, T_target_source, i, params_.assessment);
    }
    return make_unexpected(MatchFailure::kNotConverged);  // never an identity
  }

 private:
  /// The pose that fits each point to the target's nearest one; empty when too few have one.
  std::optional<Pose3> step(const MatchScan& target, const MatchScan& source,
                            const Pose3& T_target_source) const {
    const SurfacePoints& points = source.surface();
    const CorrespondenceGate gate{.max_distance_m = 0.5F, .min_normal_cosine = 0.7F};
    Eigen::Matrix3Xd from(3, points.size()), to(3, points.size());
    Eigen::Index pairs = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3 p_target = T_target_source * points.points[i].cast<double>();
      const Vector3 n_target = T_target_source.R * points.normals[i].cast<double>();
      Correspondence nearest;
      if (!target.target().nearest(p_target.cast<float>(), n_target.cast<float>(), gate, nearest))
        continue;
      from.col(pairs) = points.points[i].cast<double>();
      to.col(pairs++) = nearest.point.cast<double>();
    }
    if (pairs < params_.min_points) return std::nullopt;
    const Eigen::Matrix4d T = Eigen::umeyama(from.leftCols(pairs), to.leftCols(pairs), false);
    return Pose3(T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()).normalized();
  }

  MatchingParams params_;
};

}  // namespace

std::unique_ptr<ScanMatcher> makePointIcp(const MatchingParams& params) {
  return std::make_unique<PointIcp>(params);
}

}  // namespace dynemo
