// One measure for the results of all matchers.
#pragma once

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// What the two scans say about the pose some method has found: kNoOverlap or kDegenerate when that
/// is too little, kContradicted when it is that the pose is wrong.
Expected<ScanMatch, MatchFailure> assessMatch(const MatchScan& target, const MatchScan& source,
                                              const Pose3& T_target_source, int iterations,
                                              const AssessmentParams& params);

}  // namespace dynemo
