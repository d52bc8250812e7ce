#pragma once

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

std::unique_ptr<ScanMatcher> makePointIcp(const MatchingParams& params);

}  // namespace dynemo
