#include "dynemo/odometry/registration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dynemo/odometry/degeneracy.h"
#include "normal_equations.h"

namespace dynemo {
namespace {

/// Points per partial sum; fixed, so that sums do not depend on the number of threads.
constexpr std::size_t kBlock = 256;

/// [pose; twist; acceleration].
using Vector18 = Eigen::Matrix<double, 18, 1>;
using Matrix18 = MotionCovariance;
/// Keeps the metric regular when all points lie on a line through the base [m²].
constexpr double kMassFloor = 1e-4;
/// Of points of scan lines, in final distances of correspondences: farther away they would find
/// surfaces that they are not on.
constexpr double kLineReach = 2.0;
/// Factors of the powers of τ in the motion.
constexpr std::array<double, NormalEquations::kDegree + 1> kTaylor{1.0, 1.0, 0.5};

Matrix6 bodyToWorld(const Matrix3& R) {
  Matrix6 world = Matrix6::Zero();
  world.topLeftCorner<3, 3>() = world.bottomRightCorner<3, 3>() = R;
  return world;
}

struct Iterate {
  Pose3 T_target_base;
  SweepMotion motion;
};

/// How strict an iteration is.
struct Strictness {
  double correspondence_m;
  double kernel_m;
};

/// The equations of one step, in coordinates y of each of the three perturbations d = S y in world
/// axes, such that |y| is the root mean square displacement of the points in metres.
struct System {
  Matrix6 S = Matrix6::Identity();
  Matrix18 information = Matrix18::Zero();
  Vector18 pull = Vector18::Zero();

  Matrix18 allOfS() const {
    Matrix18 all = Matrix18::Zero();
    for (int i = 0; i < 18; i += 6) all.block<6, 6>(i, i) = S;
    return all;
  }
};

class Solver {
 public:
  Solver(const SurfacePoints& scan, const RegistrationTarget& target,
         const RegistrationPrior& prior, const RegistrationParams& params, WorkerPool& pool)
      : scan_(scan), target_(target), prior_(prior), params_(params), pool_(pool) {}

  Expected<Registration, OdometryFailure> run();
  Expected<Registration, OdometryFailure> assess();

 private:
  Strictness strictnessAt(int iteration) const;
  bool strictest(const Strictness& s) const {
    return s.correspondence_m <= params_.min_correspondence_m && s.kernel_m <= params_.kernel_m;
  }
  bool enough(const NormalEquations& sums) const {
    return sums.matched >= static_cast<std::size_t>(params_.min_correspondences) &&
           sums.normal_weight > 0.0;
  }
  NormalEquations linearize(const Iterate& at, const Strictness& strictness) const;
  void linearizeBlock(const Iterate& at, const Strictness& strictness, std::size_t begin,
                      std::size_t end, NormalEquations& sums) const;
  bool weigh(const Correspondence& match, const Eigen::Vector3f& normal, double kernel_m,
             WeightedResidual& r) const;
  System buildSystem(const Iterate& at, const NormalEquations& sums);
  void addData(const NormalEquations& sums, System& system) const;
  void addPosePrior(const Iterate& at, System& system) const;
  void addMotionPrior(const Iterate& at, System& system) const;
  bool converged(const Vector18& step) const;
  void apply(const Vector18& step, Iterate& at) const;
  Registration result(const Iterate& at, const System& system, const NormalEquations& sums,
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
  r.n = normal.cast<double>();
  r.n_target = match.normal.cast<double>();
  const double cosine = std::clamp(r.n_target.dot(r.n), -1.0, 1.0);
  if (cosine < 0.0) r.n = -r.n;
  if (params_.metric == RegistrationMetric::kPlane) {
    r.b = r.n_target;
    r.weight_normal = 1.0;
  } else {
    const double delta = params_.plane_thickness;
    r.b = (r.n_target + r.n).normalized();
    r.weight_normal = 2.0 * delta / (2.0 - (1.0 - delta) * (1.0 + std::abs(cosine))) - delta;
  }
  r.along_normal = r.b.dot(r.e);
  const double ratio = r.along_normal / kernel_m;
  const double cauchy = 1.0 / (1.0 + ratio * ratio);
  r.weight = cauchy;
  r.weight_normal *= cauchy;
  return cauchy > 0.5;
}

void Solver::linearizeBlock(const Iterate& at, const Strictness& strictness, std::size_t begin,
                            std::size_t end, NormalEquations& sums) const {
  const PointCarrier carrier(at.motion);
  const Eigen::Matrix3f R = at.T_target_base.R.cast<float>();
  const CorrespondenceGate gate{static_cast<float>(strictness.correspondence_m),
                                static_cast<float>(params_.min_normal_cosine), prior_.wide};
  // A line does not tell how its surface faces, but it has been seen.
  CorrespondenceGate line_gate = gate;
  line_gate.min_normal_cosine = 0.0F;
  line_gate.max_distance_m =
      std::min(gate.max_distance_m, static_cast<float>(kLineReach * params_.min_correspondence_m));
  Correspondence match;
  WeightedResidual r{};
  for (std::size_t i = begin; i < end; ++i) {
    Eigen::Vector3f p_base = scan_.points[i];
    if (scan_.timed()) {
      p_base = carrier.toReference(scan_.time_s[i], p_base);
      r.tau_s = static_cast<double>(scan_.time_s[i]);
    }
    r.s = at.T_target_base.R * p_base.cast<double>();
    const Vector3 p_target = r.s + at.T_target_base.t;
    const Eigen::Vector3f normal = R * scan_.normals[i];
    const bool on_surface = i < scan_.onSurfaces();
    if (!target_.nearest(p_target.cast<float>(), normal, on_surface ? gate : line_gate, match))
      continue;
    r.e = match.point.cast<double>() - p_target;
    const bool inlier = weigh(match, on_surface ? normal : match.normal, strictness.kernel_m, r);
    sums.add(r);
    if (!on_surface) continue;
    ++sums.matched;
    if (inlier) ++sums.inliers;
  }
}

NormalEquations Solver::linearize(const Iterate& at, const Strictness& strictness) const {
  const bool planar = params_.metric == RegistrationMetric::kPlane;
  const NormalEquations zero(scan_.timed(), planar ? 0.0 : params_.plane_thickness);
  std::vector<NormalEquations> partial((scan_.size() + kBlock - 1) / kBlock, zero);
  pool_.blocks(scan_.size(), kBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
    linearizeBlock(at, strictness, begin, end, partial[block]);
  });
  NormalEquations sums = zero;
  for (const NormalEquations& block : partial) sums.add(block);
  return sums;
}

/// The scan's own information, in the directions it observes.
void Solver::addData(const NormalEquations& sums, System& system) const {
  const double variance = std::max(params_.min_residual_m * params_.min_residual_m,
                                   sums.squared_residuals / sums.normal_weight);
  const Matrix6 observed = system.S * degeneracy_.projector;
  const int degree = scan_.timed() ? NormalEquations::kDegree : 0;
  for (int i = 0; i <= degree; ++i) {
    const double factor_i = kTaylor[static_cast<std::size_t>(i)] / variance;
    system.pull.segment<6>(6 * i) = factor_i * (observed.transpose() * sums.gradient(i));
    for (int j = 0; j <= degree; ++j) {
      system.information.block<6, 6>(6 * i, 6 * j) =
          factor_i * kTaylor[static_cast<std::size_t>(j)] *
          (observed.transpose() * sums.hessian(i + j) * observed);
    }
  }
}

/// Carries the unobserved directions of the pose.
void Solver::addPosePrior(const Iterate& at, System& system) const {
  if (!degeneracy_.any()) return;
  const Matrix6 world = bodyToWorld(at.T_target_base.R);
  const Matrix6 unobserved = Matrix6::Identity() - degeneracy_.projector;
  const Matrix6 J = system.S.inverse() * world;
  const Matrix6 information =
      unobserved * (J * prior_.covariance * J.transpose()).inverse() * unobserved;
  system.information.topLeftCorner<6, 6>() += information;
  system.pull.head<6>() += information * (J * local(at.T_target_base, prior_.T_target_base));
}

void Solver::addMotionPrior(const Iterate& at, System& system) const {
  const Matrix6 world = bodyToWorld(at.T_target_base.R);
  const auto add = [&](int offset, const BodyTwist& expected, const BodyTwist& now,
                       double sigma_linear, double sigma_angular) {
    Vector6 information;
    information << Vector3::Constant(std::pow(sigma_linear, -2)),
        Vector3::Constant(std::pow(sigma_angular, -2));
    const Matrix6 weighted = system.S.transpose() * information.asDiagonal();
    system.information.block<6, 6>(offset, offset) += weighted * system.S;
    system.pull.segment<6>(offset) += weighted * (world * (expected.vector() - now.vector()));
  };
  add(6, prior_.motion.twist, at.motion.twist, prior_.sigma_linear_m_s, prior_.sigma_angular_rad_s);
  // Whatever carries the sensor does not rise or sink for long; without this, a height that nothing
  // shows runs away with the noise of its speed.
  const double vertical_information = std::pow(prior_.sigma_vertical_m_s, -2);
  const Eigen::Matrix<double, 1, 6> J_vertical = system.S.row(2);
  const double speed = (world * at.motion.twist.vector())[2];
  system.information.block<6, 6>(6, 6) +=
      vertical_information * J_vertical.transpose() * J_vertical;
  system.pull.segment<6>(6) -= vertical_information * speed * J_vertical.transpose();
  add(12, prior_.motion.acceleration, at.motion.acceleration, prior_.sigma_acceleration_m_s2,
      prior_.sigma_angular_acceleration_rad_s2);
}

/// Gauss–Newton with the displacement of the points as the metric of the perturbations: the
/// degeneracy test then compares, for any direction, how much of the displacement shows along the
/// normals.
System Solver::buildSystem(const Iterate& at, const NormalEquations& sums) {
  System system;
  const Matrix6 mass = sums.massMatrix() / sums.weight + kMassFloor * Matrix6::Identity();
  const Matrix6 L = mass.llt().matrixL();
  system.S = L.transpose().inverse();
  degeneracy_ = findDegeneracy(system.S.transpose() * sums.agreement() * system.S / sums.weight,
                               params_.min_observed_share);
  addData(sums, system);
  addPosePrior(at, system);
  addMotionPrior(at, system);
  return system;
}

bool Solver::converged(const Vector18& step) const {
  return step.head<3>().norm() < params_.translation_tolerance_m &&
         step.segment<3>(3).norm() < params_.rotation_tolerance_rad;
}

void Solver::apply(const Vector18& step, Iterate& at) const {
  const Matrix3 R_base_world = at.T_target_base.R.transpose();
  const auto body = [&](int offset) {
    Vector6 d;
    d << R_base_world * step.segment<3>(offset), R_base_world * step.segment<3>(offset + 3);
    return d;
  };
  at.T_target_base = at.T_target_base.retract(body(0));
  if (!scan_.timed()) return;
  at.motion.twist = BodyTwist::fromVector(at.motion.twist.vector() + body(6));
  at.motion.acceleration = BodyTwist::fromVector(at.motion.acceleration.vector() + body(12));
}

Registration Solver::result(const Iterate& at, const System& system, const NormalEquations& sums,
                            int iterations) const {
  const Matrix3 R = at.T_target_base.R.transpose();
  Matrix18 axes = Matrix18::Zero();
  for (int i = 0; i < 18; i += 3) axes.block<3, 3>(i, i) = R;
  Registration found;
  found.T_target_base = at.T_target_base;
  found.motion = at.motion;
  const Matrix18 J = axes * system.allOfS();
  found.covariance =
      J * Eigen::LDLT<Matrix18>(system.information).solve(Matrix18::Identity()) * J.transpose();
  if (!scan_.timed()) {
    found.covariance.bottomRows<12>().setZero();
    found.covariance.rightCols<12>().setZero();
  }
  OdometryDiagnostics& diagnostics = found.diagnostics;
  const auto points = static_cast<double>(scan_.onSurfaces());
  diagnostics.points = scan_.size();
  diagnostics.overlap = static_cast<double>(sums.matched) / points;
  diagnostics.inlier_ratio = static_cast<double>(sums.inliers) / points;
  diagnostics.residual_rms_m = std::sqrt(sums.squared_residuals / sums.normal_weight);
  diagnostics.iterations = iterations;
  diagnostics.smallest_share = degeneracy_.smallest_share;
  diagnostics.degenerate_directions = J.topLeftCorner<6, 6>() * degeneracy_.directions;
  return found;
}

Expected<Registration, OdometryFailure> Solver::run() {
  Iterate at{prior_.T_target_base, prior_.motion};
  for (int iteration = 0; iteration < params_.max_iterations; ++iteration) {
    const Strictness strictness = strictnessAt(iteration);
    const NormalEquations sums = linearize(at, strictness);
    if (!enough(sums)) return make_unexpected(OdometryFailure::kNoOverlap);
    const System system = buildSystem(at, sums);
    const Vector18 step =
        system.allOfS() * Eigen::LDLT<Matrix18>(system.information).solve(system.pull);
    if (!step.allFinite()) break;
    apply(step, at);
    const bool last = iteration + 1 == params_.max_iterations;
    if ((strictest(strictness) && converged(step)) || last) {
      return result(at, system, sums, iteration + 1);
    }
  }
  return make_unexpected(OdometryFailure::kNotConverged);
}

Expected<Registration, OdometryFailure> Solver::assess() {
  const Iterate at{prior_.T_target_base, prior_.motion};
  const NormalEquations sums = linearize(at, {params_.min_correspondence_m, params_.kernel_m});
  if (!enough(sums)) return make_unexpected(OdometryFailure::kNoOverlap);
  const System system = buildSystem(at, sums);
  return result(at, system, sums, 0);
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

Expected<Registration, OdometryFailure> assessRegistration(const SurfacePoints& scan,
                                                           const RegistrationTarget& target,
                                                           const RegistrationPrior& prior,
                                                           const RegistrationParams& params,
                                                           WorkerPool& pool) {
  if (scan.size() < static_cast<std::size_t>(params.min_correspondences)) {
    return make_unexpected(OdometryFailure::kTooFewPoints);
  }
  return Solver(scan, target, prior, params, pool).assess();
}

}  // namespace dynemo
