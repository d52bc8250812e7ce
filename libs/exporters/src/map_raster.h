// The walls of a map seen from above, coloured by when they were seen.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "dynemo/query/point_owners.h"

namespace dynemo {

/// A rectangle of the map and its picture: x to the right, y up.
struct MapView {
  Eigen::AlignedBox2d area_m;
  double pixel_m = 0.01;

  cv::Size size() const;
  /// Pixel coordinates of a point of the map.
  cv::Point2d pixel(const Vector3& p_map) const;
};

/// Of keyframe `index` out of `count`: blue for the first, through violet, to orange for the last.
cv::Vec3f colorOfTime(std::size_t index, std::size_t count);

/// A point of the structure: what stands on the ground and is neither an entity nor passing by.
struct RasterPoint {
  Eigen::Vector3f p_base;
  std::uint32_t keyframe = 0;  ///< its index
};

/// The structure in the scans of all keyframes between 0.2 and 1.8 m over the ground. At most
/// `budget` points, evenly thinned.
std::vector<RasterPoint> structurePoints(const CSceneGraph& graph, const PointOwners& owners,
                                         std::size_t budget);

/// Paints the points at the given keyframe poses. Where passes agree their colours mix on one thin
/// wall; where they do not, walls are double.
cv::Mat paintStructure(const std::vector<RasterPoint>& points, const std::vector<Pose3>& T_map_base,
                       const MapView& view);

}  // namespace dynemo
