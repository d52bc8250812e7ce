#include "agent_motion.h"

#include <cmath>
#include <numbers>

namespace dynemo {

double displacementVariance(double time_s, const QueryParams& params) {
  const double tau_s = params.agent_persistence_s, s = std::abs(time_s) / tau_s;
  // For short times the terms cancel; their series is (v t)².
  const double curve = s < 1e-3 ? 0.5 * s * s : s + std::exp(-s) - 1.0;
  return 2.0 * params.agent_speed_mps * params.agent_speed_mps * tau_s * tau_s * curve;
}

double headingVariance(double time_s, const QueryParams& params) {
  constexpr double kUniform_rad2 = std::numbers::pi * std::numbers::pi / 3.0;
  return kUniform_rad2 * (1.0 - std::exp(-std::abs(time_s) / params.agent_persistence_s));
}

Matrix6 withMotion(const Matrix6& covariance, const Matrix3& R_map_entity, double displacement_m2,
                   double heading_rad2) {
  Matrix6 sum = covariance;
  const Matrix3 in_map = Vector3(displacement_m2, displacement_m2, 0.0).asDiagonal();
  sum.topLeftCorner<3, 3>() += R_map_entity.transpose() * in_map * R_map_entity;
  sum(5, 5) += heading_rad2;
  return sum;
}

double probabilityWithin(double distance_m, double displacement_m2) {
  if (displacement_m2 <= 0.0) return 1.0;
  return 1.0 - std::exp(-0.5 * distance_m * distance_m / displacement_m2);
}

}  // namespace dynemo
