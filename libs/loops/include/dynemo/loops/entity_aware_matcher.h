// Scan matching of keyframes without the entities that moved in between (paper, Sec. IV-C).
#pragma once

#include <memory>

#include "dynemo/loops/entity_prefilter.h"
#include "dynemo/loops/loop_params.h"
#include "dynemo/loops/match_scan_cache.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// A match, and what was left out of the two scans for it.
struct EntityAwareMatch {
  FilteredPair filtered;
  double range_m = 0.0;  ///< mean of the later scan's points that were left
  /// Share of inliers at the seed, before the match.
  std::optional<double> seed_inlier_ratio;
  Expected<ScanMatch, MatchFailure> match;
};

class EntityAwareMatcher {
 public:
  /// Throws ConfigError on an unknown prefilter.
  EntityAwareMatcher(const LoopParams& params, std::unique_ptr<ScanMatcher> matcher);

  /// Both keyframes must have scans. What moved is decided at the seed and once more at the match,
  /// where the robot's drift no longer adds to an object's displacement or hides a part of it; if
  /// that is something else, the scans are matched again without it.
  EntityAwareMatch match(const CSceneGraph& graph, const LoopPair& pair, const PoseEstimate& seed);

 private:
  EntityAwareMatch matchWithout(FilteredPair filtered, const LoopPair& pair,
                                const PoseEstimate& seed);

  LoopParams params_;
  std::unique_ptr<EntityPrefilter> prefilter_;
  std::unique_ptr<ScanMatcher> matcher_;
  MatchScanCache scans_;
};

}  // namespace dynemo
