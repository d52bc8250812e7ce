// Registration of one scan to a target, with the motion during the sweep as part of the unknowns.
#pragma once

#include <cstdint>

#include "dynemo/core/error.h"
#include "dynemo/core/fields.h"
#include "dynemo/odometry/registration_target.h"
#include "dynemo/odometry/scan_odometry.h"
#include "dynemo/odometry/surface_points.h"
#include "dynemo/odometry/sweep_motion.h"

namespace dynemo {

enum class RegistrationMetric : std::uint8_t { kGicp, kPlane };

struct RegistrationParams {
  RegistrationMetric metric = RegistrationMetric::kGicp;
  int max_iterations = 30;
  double translation_tolerance_m = 2e-4;
  double rotation_tolerance_rad = 2e-5;
  double min_correspondence_m = 0.15;
  double annealing = 0.6;
  double kernel_m = 0.05;
  double kernel_share = 0.5;
  double min_normal_cosine = 0.5;
  double plane_thickness = 1e-3;
  double min_observed_share = 0.01;
  double min_residual_m = 0.005;
  int min_correspondences = 30;
};
void fields(FieldVisitor& v, RegistrationParams& p);

/// Where the search starts, and what is believed about the motion before the scan is seen.
struct RegistrationPrior {
  /// Base at the reference time; the belief that carries unobserved directions.
  Pose3 T_target_base;
  /// Of the right tangent of T_target_base.
  Matrix6 covariance = Matrix6::Identity();
  /// The motion is only estimated for scans with point times; standard deviations of the twist and
  /// of the acceleration.
  SweepMotion motion;
  double sigma_linear_m_s = 1.0;
  double sigma_angular_rad_s = 1.0;
  double sigma_acceleration_m_s2 = 5.0;
  double sigma_angular_acceleration_rad_s2 = 10.0;
  /// Of the speed along the target's z axis, about zero.
  double sigma_vertical_m_s = 0.5;
  /// Largest distance of correspondences at the start.
  double correspondence_m = 0.5;
  bool wide = false;
};

/// Of [right tangent of the pose; twist; acceleration].
using MotionCovariance = Eigen::Matrix<double, 18, 18>;

struct Registration {
  Pose3 T_target_base;
  SweepMotion motion;
  /// Zero for the motion of a scan of one instant.
  MotionCovariance covariance;
  OdometryDiagnostics diagnostics;
};

/// Generalised ICP (Segal, Haehnel, Thrun, RSS 2009) with planar covariances, or point to plane:
///   min Σ ρ(eᵢᵀ Mᵢ eᵢ),  eᵢ = qᵢ − T Exp(τᵢ ξ) pᵢ,
/// over the pose T at the reference time and, for a timed scan, the twist ξ. ρ is Cauchy's kernel
/// on the distance along the normals; its width and the gate on the distance shrink together from
/// the prior's to the final ones. Directions that too few points constrain keep the prior's value
/// and uncertainty (Degeneracy).
Expected<Registration, OdometryFailure> registerScan(const SurfacePoints& scan,
                                                     const RegistrationTarget& target,
                                                     const RegistrationPrior& prior,
                                                     const RegistrationParams& params,
                                                     WorkerPool& pool);

/// How well the scan fits at prior.T_target_base as it is, with the final strictness of `params`:
/// no step is made. The same covariance and diagnostics as after a registration.
Expected<Registration, OdometryFailure> assessRegistration(const SurfacePoints& scan,
                                                           const RegistrationTarget& target,
                                                           const RegistrationPrior& prior,
                                                           const RegistrationParams& params,
                                                           WorkerPool& pool);

}  // namespace dynemo
