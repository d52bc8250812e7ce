#include "corner_refinement.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "dynemo/perception/camera_projection.h"

namespace dynemo {
namespace {

constexpr double kCauchyScale = 3.0;  ///< whitened residual beyond which a corner loses weight
constexpr double kStepTolerance = 1e-10;
constexpr double kInitialDamping = 1e-4, kMaxDamping = 1e8;

struct Linearisation {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double cost = 0.0;              ///< Σ ρ(s), s the squared whitened residual
  double chi2 = 0.0;              ///< Σ s
  double squared_distance = 0.0;  ///< Σ squared residual [px²]
};

/// ρ(s) and ρ'(s).
std::pair<double, double> evaluate(CornerLoss loss, double s) {
  if (loss == CornerLoss::kSquared) return {s, 1.0};
  const double c2 = kCauchyScale * kCauchyScale;
  return {c2 * std::log1p(s / c2), 1.0 / (1.0 + s / c2)};
}

bool addCorner(const Pose3& T, const CameraModel& camera, const Vector3& p_entity,
               const Vector2& pixel, double sigma_px, CornerLoss loss, Linearisation& sum) {
  const auto projection = project(camera, T * p_entity);
  if (!projection) return false;
  const Vector2 residual = (projection->pixel - pixel) / sigma_px;
  Eigen::Matrix<double, 3, 6> J_point_T;  // of T·p under T ⊞ d
  J_point_T << T.R, -T.R * skew(p_entity);
  const Eigen::Matrix<double, 2, 6> J = projection->J_pixel_point * J_point_T / sigma_px;
  const auto [rho, weight] = evaluate(loss, residual.squaredNorm());
  sum.H += weight * J.transpose() * J;
  sum.g += weight * J.transpose() * residual;
  sum.cost += rho;
  sum.chi2 += residual.squaredNorm();
  sum.squared_distance += (projection->pixel - pixel).squaredNorm();
  return true;
}

std::optional<Linearisation> linearise(const Pose3& T, const CameraModel& camera,
                                       std::span<const TagMeasurement> tags, CornerLoss loss) {
  Linearisation sum;
  for (const TagMeasurement& tag : tags) {
    for (std::size_t i = 0; i < tag.corners_entity.size(); ++i) {
      if (!addCorner(T, camera, tag.corners_entity[i], tag.observation.corners_px[i], tag.sigma_px,
                     loss, sum)) {
        return std::nullopt;
      }
    }
  }
  return sum;
}

std::optional<PoseMinimum> finish(const Pose3& T, const Linearisation& at,
                                  std::size_t corner_count) {
  const Eigen::LLT<Matrix6> factor(at.H);
  if (factor.info() != Eigen::Success) return std::nullopt;
  PoseMinimum minimum;
  minimum.T_camera_entity = T;
  minimum.chi2 = at.chi2;
  minimum.reprojection_rms_px = std::sqrt(at.squared_distance / static_cast<double>(corner_count));
  // A model that explains the corners worse than their noise (calibration, tag mounting) is trusted
  // less.
  const double degrees_of_freedom = 2.0 * static_cast<double>(corner_count) - 6.0;
  const double inflation = std::max(1.0, at.chi2 / degrees_of_freedom);
  minimum.covariance = inflation * factor.solve(Matrix6::Identity());
  if (!T.isFinite() || !minimum.covariance.allFinite()) return std::nullopt;
  return minimum;
}

}  // namespace

std::optional<PoseMinimum> refine(const Pose3& T_camera_entity, const CameraModel& camera,
                                  std::span<const TagMeasurement> tags, CornerLoss loss,
                                  int max_iterations) {
  Pose3 T = T_camera_entity;
  auto current = linearise(T, camera, tags, loss);
  if (!current) return std::nullopt;
  double damping = kInitialDamping;
  for (int i = 0; i < max_iterations && damping < kMaxDamping; ++i) {
    Matrix6 damped = current->H;
    damped.diagonal() *= 1.0 + damping;
    const Vector6 step = damped.ldlt().solve(-current->g);
    if (!step.allFinite() || step.norm() < kStepTolerance) break;
    const Pose3 T_next = T.retract(step);
    const auto next = linearise(T_next, camera, tags, loss);
    if (next && next->cost <= current->cost) {
      T = T_next;
      current = next;
      damping = std::max(damping * 0.1, 1e-12);
    } else {
      damping *= 10.0;
    }
  }
  return finish(T, *current, 4 * tags.size());
}

std::optional<double> reprojectionRms_px(const Pose3& T_camera_entity, const CameraModel& camera,
                                         const TagMeasurement& tag) {
  double sum = 0.0;
  for (std::size_t i = 0; i < tag.corners_entity.size(); ++i) {
    const auto projection = project(camera, T_camera_entity * tag.corners_entity[i]);
    if (!projection) return std::nullopt;
    sum += (projection->pixel - tag.observation.corners_px[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(tag.corners_entity.size()));
}

}  // namespace dynemo
