// PCL's generalised ICP.
#pragma once

#include <memory>

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// pcl::GeneralizedIterativeClosestPoint on the prepared points, with the covariances that their
/// normals imply.
std::unique_ptr<ScanMatcher> makePclGicp(const MatchingParams& params);

}  // namespace dynemo
