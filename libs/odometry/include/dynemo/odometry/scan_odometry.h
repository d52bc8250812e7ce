// Odometry from LiDAR scans alone, or helped by the log's odometry: the one interface of all
// methods.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/core/registry.h"
#include "dynemo/core/se3.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/odometry/sweep_motion.h"

namespace dynemo {

struct OdometryParams;

/// How well one scan fitted what it was registered to.
struct OdometryDiagnostics {
  /// Points of the reduced scan that took part.
  std::size_t points = 0;
  /// Share of them with a correspondence at all, in [0, 1].
  double overlap = 0.0;
  /// Share of them with a close correspondence along the normal, in [0, 1].
  double inlier_ratio = 0.0;
  /// Weighted root mean square of the distances along the normals [m].
  double residual_rms_m = 0.0;
  int iterations = 0;
  /// Smallest eigenvalue of the mean Hessian (Degeneracy): the share of a displacement that shows
  /// along the normals in the direction where least of it does.
  double smallest_share = 0.0;
  /// Directions the scan did not observe, carried by the prediction: columns are unit vectors of
  /// the right tangent of T_odom_base with the rotations scaled by a length; empty when all six
  /// were observed.
  Eigen::Matrix<double, 6, Eigen::Dynamic> degenerate_directions = Eigen::Matrix<double, 6, 0>();
};

/// The motion found by one scan.
struct OdometryEstimate {
  Stamp stamp;
  /// Base at the scan's stamp (not at the middle of its sweep). The odom frame is the base at the
  /// first stamp.
  Pose3 T_odom_base;
  /// Base at this stamp in the base at the last stamp that had an estimate; identity for the first.
  Pose3 T_prev_base;
  /// Of the right tangent of T_prev_base.
  Matrix6 covariance = Matrix6::Zero();
  /// Motion around the middle of the sweep: what deskew() needs.
  SweepMotion motion{};
  /// True when the map was begun anew here, so that T_prev_base rests on the prediction only.
  bool restarted = false;
  OdometryDiagnostics diagnostics{};
};

/// Why a scan gave no estimate. The next scan is tried from the same state.
enum class OdometryFailure : std::uint8_t {
  kTooFewPoints,
  kStampNotIncreasing,
  kNoOverlap,
  kNotConverged,
};
std::string toString(OdometryFailure failure);

class ScanOdometry {
 public:
  virtual ~ScanOdometry() = default;

  /// Registers the scan. `rawlog_odometry` is the log's odometry at the scan's stamp; methods use
  /// it as a prediction or not, as configured. The points at `ignored` (ascending indices into the
  /// cloud) take no part. The same calls give the same bytes whatever the number of threads.
  virtual Expected<OdometryEstimate, OdometryFailure> update(
      const Scan& scan, const std::optional<OdometryState>& rawlog_odometry,
      std::span<const std::uint32_t> ignored = {}) = 0;

  /// Whether the motion of an estimate comes from the sweep itself, whose points are then taken at
  /// their own times. Else it is the mean motion since the last sweep, and sweeps are registered as
  /// if measured at one instant.
  virtual bool measuresSweepMotion() const { return false; }
};

/// Methods by name: "local_map", "keyframe_gicp".
using ScanOdometryRegistry = Registry<ScanOdometry, const OdometryParams&>;
const ScanOdometryRegistry& scanOdometries();

}  // namespace dynemo
