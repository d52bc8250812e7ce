// A scan reduced to evenly spread points with surface normals.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/odometry/sweep_motion.h"
#include "dynemo/odometry/worker_pool.h"

namespace dynemo {

struct SurfaceParams {
  double min_range_m = 0.5;
  double max_range_m = 100.0;
  double leaf_m = 0.25;
  int normal_neighbors = 10;
  double normal_radius_m = 0.4;
  double max_flatness = 0.1;
  double min_view_spread = 1e-3;
  bool scan_lines = false;
};
void fields(FieldVisitor& v, SurfaceParams& p);

/// Means of the points in each leaf, in the order in which the scan first enters the leaves: first
/// those on surfaces, then those of which only a single scan line is seen.
struct SurfacePoints {
  /// Base frame at each point's own time [m].
  std::vector<Eigen::Vector3f> points;
  /// Unit, towards the sensor; base frame at the reference time. Those of scan lines are the
  /// directions to the sensor instead.
  std::vector<Eigen::Vector3f> normals;
  /// Seconds after the reference time; empty for a scan of one instant.
  std::vector<float> time_s;
  /// How many of the last points are on scan lines.
  std::size_t on_lines = 0;
  /// Of these, seen from the sensor [rad].
  std::vector<float> line_elevation_rad;

  std::size_t size() const { return points.size(); }
  std::size_t onSurfaces() const { return points.size() - on_lines; }
  bool timed() const { return !time_s.empty(); }
};

/// Reduces the scan to one mean per leaf and fits a plane to the k nearest means of each. Points
/// out of range, the `ignored` ones (ascending indices) and leaves whose neighbours do not form a
/// surface (a line, a blob) are left out, but for single scan lines if asked for. `times_s` is empty or one entry per point; `reference_s`
/// is the reference time after the stamp. The twist only serves the normals: the points keep their
/// own times.
SurfacePoints extractSurface(const Scan& scan, std::span<const float> times_s, double reference_s,
                             const SweepMotion& motion, std::span<const std::uint32_t> ignored,
                             const SurfaceParams& params, WorkerPool& pool);

}  // namespace dynemo
