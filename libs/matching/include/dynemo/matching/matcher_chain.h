// Coarse to fine: matchers that refine each other's results.
#pragma once

#include <memory>

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// The matchers named by params.chain, each starting from the one before. A poor prior makes the
/// first one start at several yaw angles, of which the best fit goes on. Only the last one's
/// failure counts: where an earlier one finds nothing, the next starts from what there is.
/// Throws ConfigError for an empty chain or an unknown name.
std::unique_ptr<ScanMatcher> makeScanMatcher(const MatchingParams& params);

}  // namespace dynemo
