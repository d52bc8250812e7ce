#include "dynemo/perception/pose_ambiguity.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

/// Squared whitened deviation beyond which a prior says nothing more: a fallen box, or one that was
/// turned.
constexpr double kMaxPriorEvidence = 16.0;

template <int N>
double squaredDeviation(const Eigen::Matrix<double, N, 1>& e, const Matrix6& covariance,
                        double sigma_rad) {
  Eigen::Matrix<double, N, N> S = covariance.block<N, N>(3, 3);
  S.diagonal().array() += sigma_rad * sigma_rad;
  return std::min(kMaxPriorEvidence, e.dot(S.ldlt().solve(e)));
}

double uprightDeviation(const PoseMinimum& pose, const Vector3& up_camera, double sigma_rad) {
  const Vector3 up = pose.T_camera_entity.R.transpose() * up_camera;  // in the entity frame
  const double sine = std::hypot(up.x(), up.y());
  const double angle = std::atan2(sine, up.z());
  const double scale = sine > 1e-12 ? angle / sine : 1.0;
  return squaredDeviation<2>(scale * Vector2(-up.y(), up.x()), pose.covariance, sigma_rad);
}

double predictionDeviation(const PoseMinimum& pose, const Matrix3& R_predicted, double sigma_rad) {
  const Vector3 w = logSO3(R_predicted.transpose() * pose.T_camera_entity.R);
  return squaredDeviation<3>(w, pose.covariance, sigma_rad);
}

/// By how much the second minimum is less likely than the best, in squared whitened error; negative
/// when it is more.
struct Evidence {
  double image = 0.0, upright = 0.0, prediction = 0.0;
};

Evidence weigh(const EntityPoseSolution& solution, const OrientationPrior& prior,
               const AmbiguityParams& params) {
  const PoseMinimum &a = solution.best, &b = *solution.second;
  Evidence evidence;
  // Residuals larger than the noise model says make every difference of them count less.
  const double scale = std::max(1.0, a.chi2 / std::max(1, solution.degrees_of_freedom));
  evidence.image = (b.chi2 - a.chi2) / scale;
  if (prior.up_camera) {
    evidence.upright = uprightDeviation(b, *prior.up_camera, params.upright_sigma_rad) -
                       uprightDeviation(a, *prior.up_camera, params.upright_sigma_rad);
  }
  if (prior.R_camera_entity) {
    evidence.prediction =
        predictionDeviation(b, *prior.R_camera_entity, params.prediction_sigma_rad) -
        predictionDeviation(a, *prior.R_camera_entity, params.prediction_sigma_rad);
  }
  return evidence;
}

/// Mean at the likelier minimum, covariance over both.
PoseMinimum blend(const PoseMinimum& likelier, const PoseMinimum& other, double evidence) {
  PoseMinimum result = likelier;
  const double probability_other = 1.0 / (1.0 + std::exp(0.5 * evidence));
  const Vector6 apart = local(likelier.T_camera_entity, other.T_camera_entity);
  result.covariance += probability_other * apart * apart.transpose();
  return result;
}

}  // namespace

Expected<ResolvedPose, TagPoseFailure> resolveAmbiguity(const EntityPoseSolution& solution,
                                                        const OrientationPrior& prior,
                                                        const AmbiguityParams& params) {
  if (!solution.second) return ResolvedPose{solution.best, true};
  const Evidence e = weigh(solution, prior, params);
  const double own = e.image + e.upright, total = own + e.prediction;
  const PoseMinimum& likelier = total >= 0.0 ? solution.best : *solution.second;
  const PoseMinimum& other = total >= 0.0 ? *solution.second : solution.best;
  // What the image and the upright prior say of the minimum that all evidence together prefers.
  const double own_for_likelier = total >= 0.0 ? own : -own;
  if (std::abs(total) >= params.min_evidence) {
    return ResolvedPose{likelier, own_for_likelier >= params.min_evidence};
  }
  if (params.fallback == AmbiguityParams::Fallback::kReject) {
    return make_unexpected(TagPoseFailure::kAmbiguous);
  }
  return ResolvedPose{blend(likelier, other, std::abs(total)), false};
}

}  // namespace dynemo
