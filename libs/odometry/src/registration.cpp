#include "dynemo/odometry/registration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "dynemo/odometry/degeneracy.h"
#include "normal_equations.h"

namespace dynemo {
namespace {

/// Points per partial sum; fixed, so that sums do not depend on the number of threads.
constexpr std::size_t kBlock = 256;

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

struct Iterate {
  Pose3 T_target_base;
  BodyTwist twist;
};

/// How strict an iteration is.
struct Strictness {
  double correspondence_m;
  double kernel_m;
};

struct Step {
  Vector12 d = Vector12::Zero();
  /// Inverse of the weighted Hessian times the residual variance, world axes.
  Matrix12 covariance = Matrix12::Zero();
};

class Solver {
 public:
  Solver(const SurfacePoints& scan, const RegistrationTarget& target,
         const RegistrationPrior& prior, const RegistrationParams& params, WorkerPool& pool)
      : scan_(scan), target_(target), prior_(prior), params_(params), pool_(pool) {}

  Expected<Registration, OdometryFailure> run();

 private:
  Strictness strictnessAt(int iteration) const;
  bool strictest(const Strictness& s) const {
    return s.correspondence_m <= params_.min_correspondence_m && s.kernel_m <= params_.kernel_m;
  }
  NormalEquations linearize(const Iterate& at, const Strictness& strictness) const;
  void linearizeBlock(const Iterate& at, const Strictness& strictness, std::size_t begin,
                      std::size_t end, NormalEquations& sums) const;
  bool weigh(const Correspondence& match, const Eigen::Vector3f& normal, double kernel_m,
             WeightedResidual& r) const;
  Step solve(const Iterate& at, const NormalEquations& sums);
  Matrix12 scaledInformation(const NormalEquations& sums, const Vector6& scale,
                             double variance) const;
  bool converged(const Step& step) const;
  void apply(const Step& step, Iterate& at) const;
  Registration result(const Iterate& at, const Step& step, const NormalEquations& sums,
                      int iterations) const;

  const SurfacePoints& scan_;
  const RegistrationTarget& target_;
  const RegistrationPrior& prior_;
  const RegistrationParams& params_;
  WorkerPool& pool_;
  Degeneracy degeneracy_;
};

Strictness Solver::strictnessAt(int iteration) const {
  const double shrunk_m = prior_.correspondence_m * std::pow(params_.annealing, iteration);
  return {std::max(params_.min_correspondence_m, shrunk_m),
          std::max(params_.kernel_m, params_.kernel_share * shrunk_m)};
}

/// The planar covariances C = I − (1 − δ) n nᵀ of both points add up to a matrix whose eigenvectors
/// are the normals' bisector b, their difference and their cross product. Its inverse, scaled by 2δ
/// so that two parallel planes weigh 1 along b, is nearly k b bᵀ + δ I: neighbours that disagree in
/// direction weigh less.
bool Solver::weigh(const Correspondence& match, const Eigen::Vector3f& normal, double kernel_m,
                   WeightedResidual& r) const {
  const Vector3 target_normal = match.normal.cast<double>();
  if (params_.metric == RegistrationMetric::kPlane) {
    r.b = target_normal;
    r.weight_normal = 1.0;
    r.weight_isotropic = 0.0;
  } else {
    double cosine = target_normal.dot(normal.cast<double>());
    const double sign = cosine < 0.0 ? -1.0 : 1.0;
    cosine = std::min(1.0, std::abs(cosine));
    const double delta = params_.plane_thickness;
    r.b = (target_normal + sign * normal.cast<double>()).normalized();
    r.weight_normal = 2.0 * delta / (2.0 - (1.0 - delta) * (1.0 + cosine)) - delta;
    r.weight_isotropic = delta;
  }
  r.along_normal = r.b.dot(r.e);
  const double ratio = r.along_normal / kernel_m;
  const double cauchy = 1.0 / (1.0 + ratio * ratio);
  r.weight_normal *= cauchy;
  r.weight_isotropic *= cauchy;
  return cauchy > 0.5;
}

void Solver::linearizeBlock(const Iterate& at, const Strictness& strictness, std::size_t begin,
                            std::size_t end, NormalEquations& sums) const {
  const Eigen::Vector3f linear = at.twist.linear_m_s.cast<float>();
  const Eigen::Vector3f angular = at.twist.angular_rad_s.cast<float>();
  const Eigen::Matrix3f R = at.T_target_base.R.cast<float>();
  const CorrespondenceGate gate{static_cast<float>(strictness.correspondence_m),
                                static_cast<float>(params_.min_normal_cosine), prior_.wide};
  Correspondence match;
  WeightedResidual r{};
  for (std::size_t i = begin; i < end; ++i) {
    Eigen::Vector3f p_base = scan_.points[i];
    if (scan_.timed()) {
      p_base = carriedToReference<float>(linear, angular, scan_.time_s[i], p_base);
      r.tau_s = static_cast<double>(scan_.time_s[i]);
    }
    r.s = at.T_target_base.R * p_base.cast<double>();
    const Vector3 p_target = r.s + at.T_target_base.t;
    const Eigen::Vector3f normal = R * scan_.normals[i];
    if (!target_.nearest(p_target.cast<float>(), normal, gate, match)) continue;
    r.e = match.point.cast<double>() - p_target;
    ++sums.matched;
    if (weigh(match, normal, strictness.kernel_m, r)) ++sums.inliers;
    sums.add(r);
  }
}

NormalEquations Solver::linearize(const Iterate& at, const Strictness& strictness) const {
  const NormalEquations zero(scan_.timed());
  std::vector<NormalEquations> partial((scan_.size() + kBlock - 1) / kBlock, zero);
  pool_.blocks(scan_.size(), kBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
    linearizeBlock(at, strictness, begin, end, partial[block]);
  });
  NormalEquations sums = zero;
  for (const NormalEquations& block : partial) sums.add(block);
  return sums;
}

Matrix12 Solver::scaledInformation(const NormalEquations& sums, const Vector6& scale,
                                   double variance) const {
  const auto block = [&](int order) -> Matrix6 {
    const Matrix6 H =
        scale.cwiseInverse().asDiagonal() * sums.hessian(order) * scale.cwiseInverse().asDiagonal();
    return degeneracy_.projector * H * degeneracy_.projector / variance;
  };
  Matrix12 information = Matrix12::Zero();
  information.topLeftCorner<6, 6>() = block(0);
  if (!scan_.timed()) return information;
  information.topRightCorner<6, 6>() = block(1);
  information.bottomLeftCorner<6, 6>() = block(1);
  information.bottomRightCorner<6, 6>() = block(2);
  return information;
}

/// Gauss–Newton in world axes with the rotations scaled by the points' mean lever arm, so that all
/// unknowns are lengths and the degeneracy test compares like with like.
Step Solver::solve(const Iterate& at, const NormalEquations& sums) {
  const double lever_m = std::sqrt(std::max(1e-6, sums.squared_levers / sums.weight_sum));
  const Matrix3& R = at.T_target_base.R;
  Vector6 scale;
  scale << 1, 1, 1, lever_m, lever_m, lever_m;
  const Vector6 unscale = scale.cwiseInverse();
  degeneracy_ = findDegeneracy(
      unscale.asDiagonal() * sums.normalHessian(0) * unscale.asDiagonal() / sums.weight_sum,
      params_.min_observed_share);
  const double variance = std::max(params_.min_residual_m * params_.min_residual_m,
                                   sums.squared_residuals / sums.weight_sum);

  Matrix12 information = scaledInformation(sums, scale, variance);
  Vector12 pull = Vector12::Zero();
  pull.head<6>() = degeneracy_.projector * (unscale.asDiagonal() * sums.gradient(0)) / variance;
  pull.tail<6>() = degeneracy_.projector * (unscale.asDiagonal() * sums.gradient(1)) / variance;

  Matrix6 world = Matrix6::Zero();  // tangent in the base's axes → scaled world axes
  world.topLeftCorner<3, 3>() = R;
  world.bottomRightCorner<3, 3>() = lever_m * R;
  if (degeneracy_.any()) {
    const Matrix6 onto = Matrix6::Identity() - degeneracy_.projector;
    const Matrix6 prior_information = (world * prior_.covariance * world.transpose()).inverse();
    const Vector6 towards_prior = world * local(at.T_target_base, prior_.T_target_base);
    const Matrix6 carried = onto * prior_information * onto;
    information.topLeftCorner<6, 6>() += carried;
    pull.head<6>() += carried * towards_prior;
  }
  const double linear2 = 1.0 / (prior_.sigma_linear_m_s * prior_.sigma_linear_m_s);
  const double angular2 = 1.0 / std::pow(lever_m * prior_.sigma_angular_rad_s, 2);
  Vector6 twist_information;
  twist_information << linear2, linear2, linear2, angular2, angular2, angular2;
  Vector6 twist_error;
  twist_error << R * (prior_.twist.linear_m_s - at.twist.linear_m_s),
      lever_m * (R * (prior_.twist.angular_rad_s - at.twist.angular_rad_s));
  information.bottomRightCorner<6, 6>().diagonal() += twist_information;
  pull.tail<6>() += twist_information.cwiseProduct(twist_error);

  const Eigen::LDLT<Matrix12> ldlt(information);
  Vector12 both;
  both << unscale, unscale;
  Step step;
  step.d = both.cwiseProduct(ldlt.solve(pull));
  step.covariance = both.asDiagonal() * ldlt.solve(Matrix12::Identity()) * both.asDiagonal();
  return step;
}

bool Solver::converged(const Step& step) const {
  return step.d.head<3>().norm() < params_.translation_tolerance_m &&
         step.d.segment<3>(3).norm() < params_.rotation_tolerance_rad;
}

void Solver::apply(const Step& step, Iterate& at) const {
  const Matrix3 R_base_world = at.T_target_base.R.transpose();
  if (scan_.timed()) {
    at.twist.linear_m_s += R_base_world * step.d.segment<3>(6);
    at.twist.angular_rad_s += R_base_world * step.d.tail<3>();
  }
  Vector6 d;
  d << R_base_world * step.d.head<3>(), R_base_world * step.d.segment<3>(3);
  at.T_target_base = at.T_target_base.retract(d);
}

Registration Solver::result(const Iterate& at, const Step& step, const NormalEquations& sums,
                            int iterations) const {
  const Matrix3 R = at.T_target_base.R.transpose();
  Matrix12 axes = Matrix12::Zero();
  for (int i = 0; i < 12; i += 3) axes.block<3, 3>(i, i) = R;
  Registration found;
  found.T_target_base = at.T_target_base;
  found.twist = at.twist;
  found.covariance = axes * step.covariance * axes.transpose();
  if (!scan_.timed()) {
    found.covariance.bottomRows<6>().setZero();
    found.covariance.rightCols<6>().setZero();
  }
  OdometryDiagnostics& diagnostics = found.diagnostics;
  diagnostics.points = scan_.size();
  diagnostics.inlier_ratio = static_cast<double>(sums.inliers) / static_cast<double>(scan_.size());
  diagnostics.residual_rms_m = std::sqrt(sums.squared_residuals / sums.weight_sum);
  diagnostics.iterations = iterations;
  diagnostics.degenerate_directions = axes.topLeftCorner<6, 6>() * degeneracy_.directions;
  return found;
}

Expected<Registration, OdometryFailure> Solver::run() {
  Iterate at{prior_.T_target_base, prior_.twist};
  for (int iteration = 0; iteration < params_.max_iterations; ++iteration) {
    const Strictness strictness = strictnessAt(iteration);
    const NormalEquations sums = linearize(at, strictness);
    if (sums.matched < static_cast<std::size_t>(params_.min_correspondences) ||
        !(sums.weight_sum > 0.0)) {
      return make_unexpected(OdometryFailure::kNoOverlap);
    }
    const Step step = solve(at, sums);
    if (!step.d.allFinite() || !step.covariance.allFinite()) {
      return make_unexpected(OdometryFailure::kNotConverged);
    }
    apply(step, at);
    const bool last = iteration + 1 == params_.max_iterations;
    if ((strictest(strictness) && converged(step)) || last) {
      return result(at, step, sums, iteration + 1);
    }
  }
  return make_unexpected(OdometryFailure::kNotConverged);
}

}  // namespace

void fields(FieldVisitor& v, RegistrationParams& p) {
  v.choice("metric", p.metric, {"gicp", "plane"},
           "Distance between planes, or from point to plane");
  v.integer("max_iterations", p.max_iterations, "Gauss-Newton steps", Range::between(1, 1000));
  v.number("translation_tolerance_m", p.translation_tolerance_m, "Step that ends the iteration",
           Range::positive());
  v.number("rotation_tolerance_rad", p.rotation_tolerance_rad, "Step that ends the iteration",
           Range::positive());
  v.number("min_correspondence_m", p.min_correspondence_m,
           "Final largest distance of correspondences", Range::positive());
  v.number(
      "annealing", p.annealing,
      "Factor per iteration from the first correspondence distance and kernel to the final ones",
      {0.0, 1.0, true});
  v.number("kernel_m", p.kernel_m, "Final distance at which Cauchy's kernel halves the weight",
           Range::positive());
  v.number("kernel_share", p.kernel_share,
           "Kernel width as a share of the correspondence distance until it is narrower than the "
           "final one: a kernel "
           "that starts too narrow diverges",
           Range::positive());
  v.number("min_normal_cosine", p.min_normal_cosine,
           "Normals of a correspondence must agree at least this much, so that the faces of a thin "
           "wall are not mixed",
           Range::between(-1.0, 1.0));
  v.number("plane_thickness", p.plane_thickness,
           "Variance of a point across its surface relative to along it (gicp only)",
           {0.0, 1.0, true});
  v.number("min_observed_share", p.min_observed_share,
           "Directions constrained by a smaller share of the correspondences are carried by the "
           "prediction",
           Range::between(0.0, 1.0));
  v.number("min_residual_m", p.min_residual_m,
           "Lower limit of the residual's standard deviation in the covariance", Range::positive());
  v.integer("min_correspondences", p.min_correspondences, "With fewer, the registration fails",
            {6, 1e6});
}

Expected<Registration, OdometryFailure> registerScan(const SurfacePoints& scan,
                                                     const RegistrationTarget& target,
                                                     const RegistrationPrior& prior,
                                                     const RegistrationParams& params,
                                                     WorkerPool& pool) {
  if (scan.size() < static_cast<std::size_t>(params.min_correspondences)) {
    return make_unexpected(OdometryFailure::kTooFewPoints);
  }
  return Solver(scan, target, prior, params, pool).run();
}

}  // namespace dynemo
