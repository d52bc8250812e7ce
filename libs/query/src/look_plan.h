// Which scans look at which places: so many at most at each, however long the robot stays around.
#pragma once

#include <cstdint>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

/// In the map frame.
struct SeenPlace {
  Eigen::Vector3f middle;
  /// Of the surface that it is on; zero when it is on none.
  Eigen::Vector3f normal;
};

/// Where and when a scan was taken.
struct Viewpoint {
  Vector3 p_map;
  Stamp stamp;
};

/// Of the viewpoints within the distance of a point `most` at most, which lie apart from each other
/// in space and time as far as they can: a robot that waits adds hardly anything to what it has
/// seen from there. Indices in ascending order.
std::vector<std::uint32_t> spreadViewpoints(const std::vector<Viewpoint>& views,
                                            const Vector3& p_map, double distance_m,
                                            std::size_t most);

/// Places in blocks of the map, each with the scans that look at it.
class LookPlan {
 public:
  LookPlan() = default;
  /// For the places of these indices, and the scans no further away than the range; `most` is the
  /// number of scans that look at a block.
  LookPlan(const std::vector<SeenPlace>& places, const std::vector<std::uint32_t>& indices,
           const std::vector<Viewpoint>& scans, double max_range_m, int most);

  bool looks(std::size_t scan) const { return !blocks_of_scan_[scan].empty(); }
  /// With the index of each place that the scan looks at.
  template <class Action>
  void forEachPlace(std::size_t scan, const Action& action) const {
    for (const std::uint32_t block : blocks_of_scan_[scan])
      for (std::uint32_t i = first_[block]; i < first_[block + 1]; ++i) action(places_[i]);
  }

 private:
  std::vector<std::uint32_t> places_;  ///< indices, by block
  std::vector<std::uint32_t> first_;   ///< of each block in `places_`, and the end
  std::vector<std::vector<std::uint32_t>> blocks_of_scan_;
};

}  // namespace dynemo
