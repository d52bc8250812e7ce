// What the scans that looked at a place have seen there.
#pragma once

#include <cstdint>

#include "beam_grid.h"
#include "dynemo/query/structure_params.h"

namespace dynemo {

enum class Permanence {
  kUnknown,
  kLasting,  ///< most scans that look there see something
  kPassing   ///< others see through
};

/// Looks in order of time.
class SightCounts {
 public:
  void add(Sight sight) {
    if (sight == Sight::kNothing) return;
    ++looks_;
    if (sight == Sight::kHit) ++hits_;
    through_since_hit_ = sight == Sight::kHit ? 0 : through_since_hit_ + 1;
  }
  Permanence judge(const StructureParams& params) const;
  /// Whether more looks would hardly change the judgement: it passes, or lasts to the end.
  bool isClear(const StructureParams& params) const {
    const Permanence permanence = judge(params);
    return permanence == Permanence::kPassing ||
           (permanence == Permanence::kLasting && through_since_hit_ == 0);
  }

 private:
  std::uint32_t looks_ = 0, hits_ = 0, through_since_hit_ = 0;
};

/// Rays along a surface pass near to its points and end far behind: only steep ones say that it is
/// not there. Both directions have unit length; a zero normal is that of no surface.
inline bool isSteep(const Eigen::Vector3f& ray, const Eigen::Vector3f& normal) {
  constexpr float kLeastSine = 0.35f;
  return normal.isZero() || std::abs(ray.dot(normal)) >= kLeastSine;
}

}  // namespace dynemo
