// How uncertain the odometry between two keyframes is.
#pragma once

#include <optional>

#include "dynemo/core/fields.h"
#include "dynemo/core/se3.h"
#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

enum class OdometryNoiseSource {
  kRecorded,  ///< growth of the covariance that the log accumulates; the model where it has none
  kModel,     ///< random walk over distance and angle
  kFitness    ///< how well the two scans agree, as S-Graphs weighs it; the model where there are no
              ///< scans
};

/// Random walk: variance = jitter² + (σ_d² · distance + σ_a² · angle) per component; recorded
/// covariances get the jitter too, since it is not part of what accumulates.
struct OdometryNoiseParams {
  OdometryNoiseSource source = OdometryNoiseSource::kRecorded;
  double translation_per_sqrt_m = 0.012;
  double translation_per_sqrt_rad = 0.01;
  double rotation_per_sqrt_m_rad = 0.004;
  double rotation_per_sqrt_rad_rad = 0.006;
  /// Factor on the model's sigmas for odometry that stays exactly in a plane: wheels slip, and know
  /// nothing of height and tilt.
  double planar_scale = 3.0;
  double jitter_m = 0.004;
  double jitter_rad = 0.001;
  /// Recorded covariances are multiplied by the square of it.
  double recorded_scale = 1.0;
  /// Added to recorded covariances: they take the drift as random and leave out systematic errors
  /// of scale.
  double systematic_per_sqrt_m = 0.010;
  /// Fitness f [m²], the mean squared nearest-neighbour distance of the scans: σ² grows from the
  /// smallest to the largest with (1 − e^(−20 f)) / (1 − e^(−20 f_max)).
  double fitness_max_m2 = 0.5;
  double fitness_min_sigma_m = 0.1, fitness_max_sigma_m = 5.0;
  double fitness_min_sigma_rad = 0.4, fitness_max_sigma_rad = 1.6;
  /// Least uncertainty of LiDAR odometry between two keyframes: its Hessian knows nothing of wrong
  /// associations.
  double lidar_min_sigma_m = 0.0005;
  double lidar_min_sigma_rad = 0.00017;
  /// Between keyframes where the odometry is missing.
  double missing_sigma_m = 2.0;
  double missing_sigma_rad = 1.0;
};
void fields(FieldVisitor& v, OdometryNoiseParams& p);

/// LiDAR odometry that registers moving sweeps as they are: sigma of the error that each adds to
/// the motion, as shares of its translation and rotation [m/m, rad/m, m/rad, rad/rad].
struct SweepDistortionParams {
  double m_per_m = 0.05, rad_per_m = 0.023;
  double m_per_rad = 0.10, rad_per_rad = 0.045;
};
void fields(FieldVisitor& v, SweepDistortionParams& p);

/// Mean squared distance [m²] from each point of `b` to its nearest neighbour in `a`, with b placed
/// by T_a_b (base frames); +∞ when either scan is empty.
double scanFitness(const Scan& a, const Scan& b, const Pose3& T_a_b);

/// What moving `motion` (right tangent) during a sweep adds to the covariance of odometry that
/// takes the sweep as measured at one instant.
Matrix6 distortionCovariance(const Vector6& motion, const SweepDistortionParams& params);

/// Isotropic covariance for a fitness, as above.
Matrix6 fitnessCovariance(double fitness_m2, const OdometryNoiseParams& params);

/// Covariance of the right tangent of T_a_b = T_odom_a⁻¹ T_odom_b. `path_m` and `path_rad` are the
/// distance and angle travelled between the two; empty states mean that the log has no odometry
/// there.
Matrix6 relativeOdometryCovariance(const std::optional<OdometryState>& a,
                                   const std::optional<OdometryState>& b, double path_m,
                                   double path_rad, const OdometryNoiseParams& params);

}  // namespace dynemo
