// What scans see of the places of a map.
#pragma once

#include <vector>

#include "look_plan.h"
#include "sight_counts.h"

namespace dynemo {

/// All scans that look, in order of time, and once more while `lookCloser`; then the judgement.
///
/// A first round of `max_looks` scans at a place is enough for most. Where it tells neither that
/// something stands there to the end nor that it only passed by, a second round of kCloser times
/// as many scans counts instead.
class PlaceSights {
 public:
  static constexpr int kCloser = 4;
  /// Whether a return at a place counts that is seen along the surface, too.
  enum class AlongSurface { kHits, kNothing };

  PlaceSights() = default;
  PlaceSights(std::vector<SeenPlace> places, std::vector<Viewpoint> scans,
              const StructureParams& params, const SightParams& sight, AlongSurface along);

  /// Whether there is anything to look at for the scan of this index.
  bool looks(std::size_t scan) const { return plan_.looks(scan); }
  void look(std::size_t scan, const BeamGrid& beams, const Pose3& T_map_lidar);
  /// Begins the second round; false when there is nothing to look at in it, or has been one.
  bool lookCloser();

  std::size_t size() const { return places_.size(); }
  Permanence at(std::size_t place) const { return sights_[place].judge(params_); }

 private:
  std::vector<SeenPlace> places_;
  std::vector<SightCounts> sights_;  ///< of each place
  std::vector<Viewpoint> scans_;
  StructureParams params_;
  SightParams sight_;
  AlongSurface along_ = AlongSurface::kHits;
  LookPlan plan_;
  bool closer_ = false;
};

}  // namespace dynemo
