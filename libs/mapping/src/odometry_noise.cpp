#include "dynemo/mapping/odometry_noise.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "dynemo/core/noise.h"

namespace dynemo {
namespace {

Matrix6 randomWalk(double path_m, double path_rad, const OdometryNoiseParams& p) {
  const auto variance = [&](double per_sqrt_m, double per_sqrt_rad) {
    return per_sqrt_m * per_sqrt_m * path_m + per_sqrt_rad * per_sqrt_rad * path_rad;
  };
  Matrix6 Q = Matrix6::Zero();
  Q.topLeftCorner<3, 3>().diagonal().setConstant(
      variance(p.translation_per_sqrt_m, p.translation_per_sqrt_rad));
  Q.bottomRightCorner<3, 3>().diagonal().setConstant(
      variance(p.rotation_per_sqrt_m_rad, p.rotation_per_sqrt_rad_rad));
  return Q;
}

/// Measured noise would never leave these at zero.
bool isPlanar(const Pose3& T) { return T.t.z() == 0.0 && T.R(2, 0) == 0.0 && T.R(2, 1) == 0.0; }

/// What the accumulated covariance grew by: Σ_b = A Σ_a Aᵀ + Q with A the propagation over T_a_b.
/// Late in a log Q is the small difference of large matrices, and a log may add its noise in other
/// axes than ours: Q is taken only where it is a covariance and within a factor of 10 in sigma of
/// the generic model.
std::optional<Matrix6> recordedGrowth(const OdometryState& a, const OdometryState& b,
                                      const Matrix6& model) {
  constexpr double kMaxSigmaRatio = 10.0;
  if (!a.accumulated_covariance || !b.accumulated_covariance) return std::nullopt;
  const Matrix6 A = composeJacobianLeft(a.T_odom_base.inverse() * b.T_odom_base);
  const Matrix6 Q = *b.accumulated_covariance - A * *a.accumulated_covariance * A.transpose();
  if (!Q.allFinite()) return std::nullopt;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> ratios(0.5 * (Q + Q.transpose()), model,
                                                                 Eigen::EigenvaluesOnly);
  if (ratios.info() != Eigen::Success ||
      ratios.eigenvalues().minCoeff() < 1.0 / (kMaxSigmaRatio * kMaxSigmaRatio) ||
      ratios.eigenvalues().maxCoeff() > kMaxSigmaRatio * kMaxSigmaRatio) {
    return std::nullopt;
  }
  return Matrix6(0.5 * (Q + Q.transpose()));
}

}  // namespace

void fields(FieldVisitor& v, OdometryNoiseParams& p) {
  v.choice("source", p.source, {"recorded", "model", "fitness"},
           "Growth of the covariance in the log (the model where it has none), the model, or the "
           "scans' agreement");
  v.number("translation_per_sqrt_m", p.translation_per_sqrt_m,
           "Model: sigma [m] per square root of a metre", Range::nonNegative());
  v.number("translation_per_sqrt_rad", p.translation_per_sqrt_rad,
           "Model: sigma [m] per square root of a radian", Range::nonNegative());
  v.angle("rotation_per_sqrt_m_deg", p.rotation_per_sqrt_m_rad,
          "Model: sigma per square root of a metre", Range::nonNegative());
  v.angle("rotation_per_sqrt_rad_deg", p.rotation_per_sqrt_rad_rad,
          "Model: sigma per square root of a radian", Range::nonNegative());
  v.number("planar_scale", p.planar_scale, "Model: factor on its sigmas for planar odometry",
           Range::positive());
  v.number("jitter_m", p.jitter_m, "Added to every relative pose, recorded or modelled",
           Range::positive());
  v.angle("jitter_deg", p.jitter_rad, "Added to every relative pose, recorded or modelled",
          Range::positive());
  v.number("recorded_scale", p.recorded_scale, "Factor on recorded standard deviations",
           Range::positive());
  v.number("systematic_per_sqrt_m", p.systematic_per_sqrt_m,
           "Added to recorded covariances: sigma [m] per square root of a metre",
           Range::nonNegative());
  v.number("fitness_max_m2", p.fitness_max_m2,
           "Fitness: mean squared scan distance that counts as worst", Range::positive());
  v.number("fitness_min_sigma_m", p.fitness_min_sigma_m, "Fitness: sigma of a perfect match",
           Range::positive());
  v.number("fitness_max_sigma_m", p.fitness_max_sigma_m, "Fitness: sigma of the worst match",
           Range::positive());
  v.angle("fitness_min_sigma_deg", p.fitness_min_sigma_rad, "Fitness: sigma of a perfect match",
          Range::positive());
  v.angle("fitness_max_sigma_deg", p.fitness_max_sigma_rad, "Fitness: sigma of the worst match",
          Range::positive());
  v.number("lidar_min_sigma_m", p.lidar_min_sigma_m,
           "Least sigma of LiDAR odometry between keyframes", Range::positive());
  v.angle("lidar_min_sigma_deg", p.lidar_min_sigma_rad,
          "Least sigma of LiDAR odometry between keyframes", Range::positive());
  v.number("missing_sigma_m", p.missing_sigma_m, "Sigma where the log has no odometry",
           Range::positive());
  v.angle("missing_sigma_deg", p.missing_sigma_rad, "Sigma where the log has no odometry",
          Range::positive());
}

void fields(FieldVisitor& v, SweepDistortionParams& p) {
  v.number("m_per_m", p.m_per_m, "Sigma [m] per metre", Range::nonNegative());
  v.number("rad_per_m", p.rad_per_m, "Sigma [rad] per metre", Range::nonNegative());
  v.number("m_per_rad", p.m_per_rad, "Sigma [m] per radian", Range::nonNegative());
  v.number("rad_per_rad", p.rad_per_rad, "Sigma [rad] per radian", Range::nonNegative());
}

Matrix6 distortionCovariance(const Vector6& motion, const SweepDistortionParams& p) {
  const double way_m = motion.head<3>().norm(), turn_rad = motion.tail<3>().norm();
  return isotropicCovariance(std::hypot(p.m_per_m * way_m, p.m_per_rad * turn_rad),
                             std::hypot(p.rad_per_m * way_m, p.rad_per_rad * turn_rad));
}

Matrix6 fitnessCovariance(double fitness_m2, const OdometryNoiseParams& p) {
  constexpr double kGain = 20.0;
  const double y = std::isfinite(fitness_m2) ? (1.0 - std::exp(-kGain * fitness_m2)) /
                                                   (1.0 - std::exp(-kGain * p.fitness_max_m2))
                                             : 1.0;
  const auto sigma = [y](double lo, double hi) {
    return std::sqrt(lo * lo + (hi * hi - lo * lo) * y);
  };
  return isotropicCovariance(sigma(p.fitness_min_sigma_m, p.fitness_max_sigma_m),
                             sigma(p.fitness_min_sigma_rad, p.fitness_max_sigma_rad));
}

Matrix6 relativeOdometryCovariance(const std::optional<OdometryState>& a,
                                   const std::optional<OdometryState>& b, double path_m,
                                   double path_rad, const OdometryNoiseParams& params) {
  if (!a || !b) return isotropicCovariance(params.missing_sigma_m, params.missing_sigma_rad);
  const double scale =
      isPlanar(a->T_odom_base) && isPlanar(b->T_odom_base) ? params.planar_scale : 1.0;
  const Matrix6 model = scale * scale * randomWalk(path_m, path_rad, params) +
                        isotropicCovariance(params.jitter_m, params.jitter_rad);
  if (params.source != OdometryNoiseSource::kRecorded) return model;
  const auto Q = recordedGrowth(*a, *b, model);
  if (!Q) return model;
  Matrix6 systematic = isotropicCovariance(params.jitter_m, params.jitter_rad);
  systematic.diagonal().head<3>().array() +=
      params.systematic_per_sqrt_m * params.systematic_per_sqrt_m * path_m;
  return params.recorded_scale * params.recorded_scale * *Q + systematic;
}

}  // namespace dynemo
