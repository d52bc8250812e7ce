// PCL's normal distributions transform.
#pragma once

#include <memory>

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// pcl::NormalDistributionsTransform (Magnusson 2009) on the prepared points.
std::unique_ptr<ScanMatcher> makePclNdt(const MatchingParams& params);

}  // namespace dynemo
