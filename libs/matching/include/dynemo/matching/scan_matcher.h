// Relative pose of two scans: the one interface of all matchers.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/registry.h"
#include "dynemo/core/se3.h"
#include "dynemo/matching/match_scan.h"

namespace dynemo {

struct MatchingParams;

/// Where to look, and how far off that may be.
struct MatchRequest {
  /// Base of the source scan in the base of the target scan.
  Pose3 T_target_source_guess;
  /// Standard deviations of the guess's error.
  double translation_sigma_m = 0.3;
  double rotation_sigma_rad = 0.1;
};

/// The relative pose and how well it is supported, judged for all matchers by the same measure
/// (assessMatch). Born pessimistic.
struct ScanMatch {
  /// Base of the source scan in the base of the target scan.
  Pose3 T_target_source;
  /// Of the right tangent of T_target_source: the inverse Hessian of the distances along the
  /// normals, scaled by their variance.
  Matrix6 covariance = 1e6 * Matrix6::Identity();
  /// Share of the source's points with a target point nearby that faces the same way, in [0, 1].
  double overlap = 0.0;
  /// Share of these that are close along the normal, in [0, 1].
  double inlier_ratio = 0.0;
  /// Weighted root mean square of the distances along the normals [m].
  double residual_rms_m = std::numeric_limits<double>::infinity();
  /// Smallest eigenvalue of the mean Hessian in coordinates whose norm is the points' displacement:
  /// the share of a displacement that shows along the normals, in the direction where least does.
  double min_eigenvalue = 0.0;
  /// Share of points that lie where the other scan's sensor looked through, the larger of both
  /// directions, in [0, 1].
  double contradiction = 1.0;
  int iterations = 0;

  /// Share of the source's points that are explained.
  double fit() const { return overlap * inlier_ratio; }
};

/// Why two scans have no match.
enum class MatchFailure : std::uint8_t {
  kTooFewPoints,
  kNoOverlap,
  kNotConverged,
  kDegenerate,    ///< the scans do not tell all six directions
  kContradicted,  ///< surfaces of one scan are where the other's sensor looked through
};
std::string toString(MatchFailure failure);

class ScanMatcher {
 public:
  virtual ~ScanMatcher() = default;
  /// The pose of the source scan's base in the target scan's. The same arguments give the same
  /// bytes. Safe to call from several threads.
  virtual Expected<ScanMatch, MatchFailure> match(const MatchScan& target, const MatchScan& source,
                                                  const MatchRequest& request) const = 0;
};

/// Single methods by name: "mrpt_icp", "annealed_gicp", "pcl_gicp", "pcl_ndt".
using ScanMatcherRegistry = Registry<ScanMatcher, const MatchingParams&>;
const ScanMatcherRegistry& scanMatchers();

}  // namespace dynemo
