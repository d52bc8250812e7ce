// The rays of one scan, to be found by direction.
#pragma once

#include <cstdint>
#include <vector>

#include "dynemo/core/point_cloud.h"

namespace dynemo {

/// What a scan says of a place.
enum class Sight {
  kNothing,  ///< no ray comes near it, or all end before it
  kHit,      ///< something is there
  kThrough   ///< rays pass it and end behind it
};

/// What a ray ends at.
enum class BeamEnd : std::uint8_t {
  kThing,  ///< may be what is looked for
  kFloor,  ///< is what it stands on
  kEntity  ///< neither; hides what is behind it
};

struct SightParams {
  /// A return this near to the place is there.
  double hit_m = 0.1;
  /// A ray passes the place when it is this near to it ...
  double ray_radius_m = 0.05;
  /// ... and ends so far behind it.
  double behind_m = 0.15;
};

/// Points of a scan in a grid of directions as seen from the sensor.
class BeamGrid {
 public:
  /// `ends` has one entry per point.
  BeamGrid(const PointCloud& cloud, const std::vector<BeamEnd>& ends);
  Sight look(const Eigen::Vector3f& p_lidar, const SightParams& params) const;

 private:
  struct Beam {
    Eigen::Vector3f direction;
    float range_m;
    BeamEnd end;
  };
  std::vector<Beam> beams_;           ///< sorted by cell
  std::vector<std::uint32_t> first_;  ///< of each cell, and the end
};

}  // namespace dynemo
