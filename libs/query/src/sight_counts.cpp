#include "sight_counts.h"

#include <algorithm>
#include <cmath>

namespace dynemo {

Permanence SightCounts::judge(const StructureParams& params) const {
  // Of scans that look at something that is there, at least so many miss it.
  constexpr double kLeastMissed = 0.1;
  // What most scans see is there to stay.
  constexpr double kLastingShare = 0.5;
  constexpr std::uint32_t kLastingHits = 3;
  const std::uint32_t through = looks_ - hits_;
  if (through >= static_cast<std::uint32_t>(params.min_through)) {
    if (hits_ < params.max_hit_share * looks_) return Permanence::kPassing;
    const double seen_while_there =
        std::min(1.0 - kLeastMissed, static_cast<double>(hits_) / (looks_ - through_since_hit_));
    if (std::pow(1.0 - seen_while_there, through_since_hit_) <= params.gone_probability)
      return Permanence::kPassing;
  }
  const bool lasting = hits_ >= kLastingHits && hits_ >= kLastingShare * looks_;
  return lasting ? Permanence::kLasting : Permanence::kUnknown;
}

}  // namespace dynemo
