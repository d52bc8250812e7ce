// A scan made ready for matching.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "dynemo/core/point_cloud.h"
#include "dynemo/matching/seen_space.h"
#include "dynemo/odometry/registration_target.h"
#include "dynemo/odometry/surface_points.h"

namespace dynemo {

/// One scan as evenly spread points with normals in the base frame, taken as measured at one
/// instant: deskew before. Made once per keyframe and kept; copies share their content, which never
/// changes, and may be used from several threads.
class MatchScan {
 public:
  MatchScan(const Scan& scan, const SurfaceParams& params);

  /// The same without every leaf that holds one of the scan's points at `removed`. Cheap: nothing
  /// is fitted again.
  MatchScan without(const Scan& scan, std::span<const std::uint32_t> removed) const;

  const SurfacePoints& surface() const;
  std::size_t size() const { return surface().size(); }
  /// Mean distance of the points from the base [m].
  double meanRange_m() const;
  /// Its points as what another scan is matched to; the search structure is built by the first
  /// call.
  const RegistrationTarget& target() const;
  /// How far the sensor saw in each direction; made by the first call.
  const SeenSpace& seenSpace() const;

 private:
  struct Content;
  explicit MatchScan(std::shared_ptr<const Content> content) : content_(std::move(content)) {}

  std::shared_ptr<const Content> content_;
};

}  // namespace dynemo
