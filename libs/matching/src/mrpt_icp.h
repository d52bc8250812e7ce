// MRPT's ICP.
#pragma once

#include <memory>

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// mrpt::slam::CICP::Align3D: Horn's closed form on nearest points, with a distance threshold that
/// shrinks. A wide basin, but point to point, so a coarse result. CICP keeps a clock shared by the
/// whole process, so that its calls wait for each other.
std::unique_ptr<ScanMatcher> makeMrptIcp(const MatchingParams& params);

}  // namespace dynemo
