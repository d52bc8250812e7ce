// The gates a scan match must pass to become a closure.
#pragma once

#include <optional>
#include <string>

#include "dynemo/loops/loop_pair.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// The measurement as the graph takes it: the matcher's covariance times the scale, and never less
/// than the floor, which grows with the residual. `range_m` is the mean range of the scan's points.
PoseEstimate honestEstimate(const ScanMatch& match, double range_m,
                            const ClosureNoiseParams& noise);

/// Why a match is not trusted by itself: inliers, overlap, residual, degeneracy; empty when it is.
/// `entities_agree`: objects confirm the relative pose, so that a direction in which the scans say
/// little does no harm.
std::optional<std::string> refusal(const ScanMatch& match, bool entities_agree,
                                   const VerificationParams& params);

/// Squared Mahalanobis distance of a measurement from the graph's estimate, the latter's standard
/// deviations scaled.
double distanceFromGraph(const PoseEstimate& measured, const PoseEstimate& predicted,
                         double drift_scale);

}  // namespace dynemo
