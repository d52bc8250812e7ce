// The project's own fine matcher.
#pragma once

#include <memory>

#include "dynemo/matching/matching_params.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// Generalised ICP with Cauchy's kernel and a gate on the normals, whose correspondence distance
/// and kernel shrink from as wide as the guess is poor to a few centimetres (registerScan).
std::unique_ptr<ScanMatcher> makeAnnealedGicp(const MatchingParams& params);

}  // namespace dynemo
