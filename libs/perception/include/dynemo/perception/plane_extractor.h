// Large planes in a scan: walls, ceiling, ground.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/core/registry.h"
#include "dynemo/graph/plane_patch.h"

namespace dynemo {

struct PlaneParams {
  /// Name of a registered extractor.
  std::string extractor = "range_image";
  /// Noise of the ranges; estimated from each scan when empty.
  std::optional<double> range_sigma_m;
  /// Planes with fewer points, or less extended, are left out: faces of movable things.
  int min_points = 100;
  double min_length_m = 1.2;
  double min_width_m = 0.5;
  /// Parts of one plane further apart than this are planes of their own.
  double max_gap_m = 30.0;
  /// What the noise of the points does not show: walls are not quite flat, sensors not quite
  /// calibrated.
  double min_sigma_offset_m = 0.002;
  double min_sigma_normal_rad = 0.001;
};
void fields(FieldVisitor& v, PlaneParams& p);

/// One plane seen in one scan, in the base frame.
struct PlaneObservation {
  /// The normal points to the side of the sensor; the center is the mean of the points.
  PlanePatch patch_base;
  /// Of [w_1 w_2 δ]: the normal's tangent (core/plane3.h), and the offset at the center.
  Matrix3 covariance = Matrix3::Identity();
  /// Of the distances of the points from the plane.
  double rms_m = 0.0;
  /// Its points in the scan: the plane's support, not all that lies on its unbounded plane.
  PointIndices points;
};

/// Whether most of the plane's points are points of an entity's fragment (ascending indices): such
/// a plane may be carried away.
bool isFaceOf(const PlaneObservation& plane, const PointIndices& fragment);

class PlaneExtractor {
 public:
  virtual ~PlaneExtractor() = default;
  /// Planes by number of points, descending. The same scan gives the same planes.
  virtual std::vector<PlaneObservation> extract(const Scan& scan) const = 0;
};

/// Extractors by name: "range_image" grows planes on the rows and columns of the scan, also when it
/// is a bare list of points ring by ring, and leaves scans without such an order to "ransac".
using PlaneExtractorRegistry = Registry<PlaneExtractor, const PlaneParams&>;
const PlaneExtractorRegistry& planeExtractors();

}  // namespace dynemo
