// Sums of the Gauss–Newton equations of one scan's registration.
//
// A world-axes perturbation d = (dt, dθ) of the pose, dξ of the twist and dα of the acceleration
// moves a point at lever arm s from the base and time τ from the reference by A (d + τ dξ + τ²/2
// dα) with A = [I, −[s]×]. The residual e = q − p is weighted with
//   M = w (k b bᵀ + ε I),
// b the bisector of the two normals: a row a = [b; s×b] along it and the small isotropic part ε.
//
// Normals are noisy, and a bᵀ b of noise alone looks like information in directions that no surface
// faces. The noise of a scan's normal n and of its partner's n′ is independent, so that the mean of
// the products a(n) a(n′)ᵀ has none of it: agreement() sums these.
#pragma once

#include <array>

#include "dynemo/core/se3.h"

namespace dynemo {

/// One correspondence, weighted.
struct WeightedResidual {
  Vector3 e, s, b;
  Vector3 n, n_target;   ///< both normals, in one sense
  double along_normal;   ///< b · e
  double weight;         ///< w
  double weight_normal;  ///< w k
  double tau_s;
};

class NormalEquations {
 public:
  /// Highest power of τ in the motion.
  static constexpr int kDegree = 2;

  /// A scan of one instant needs the sums of order 0 only; `isotropy` is ε.
  NormalEquations(bool timed, double isotropy)
      : degree_(timed ? kDegree : 0), isotropy_(isotropy) {}

  void add(const WeightedResidual& r);
  void add(const NormalEquations& other);

  /// Σ w AᵀA.
  Matrix6 massMatrix() const { return massPart(0); }
  /// Σ w (a(n) a(n′)ᵀ + a(n′) a(n)ᵀ) / 2. Not weighted by k, which favours noise that agrees.
  Matrix6 agreement() const { return symmetric(agreement_.data()); }
  /// Σ τᵏ AᵀMA.
  Matrix6 hessian(int order) const { return normalPart(order) + isotropy_ * massPart(order); }
  /// Σ τᵏ AᵀM e.
  const Vector6& gradient(int order) const { return gradient_[static_cast<std::size_t>(order)]; }

  std::size_t matched = 0, inliers = 0;
  /// Σ w k, Σ w, Σ w k (b·e)².
  double normal_weight = 0.0, weight = 0.0, squared_residuals = 0.0;

 private:
  /// Per order: the upper triangle of Σ wk a aᵀ (21), Σ w (1), Σ w s (3), the upper triangle of Σ
  /// wε s sᵀ (6).
  static constexpr int kUpper = 21;
  static constexpr int kTerms = kUpper + 10;
  using Terms = Eigen::Array<double, kTerms + 1, 1>;

  void addAgreement(const WeightedResidual& r);
  static Matrix6 symmetric(const double* upper);
  static Terms termsOf(const Vector6& a, const WeightedResidual& r);
  Matrix6 normalPart(int order) const;
  Matrix6 massPart(int order) const;

  int degree_;
  double isotropy_;
  std::array<Terms, 2 * kDegree + 1> sums_{Terms::Zero(), Terms::Zero(), Terms::Zero(),
                                           Terms::Zero(), Terms::Zero()};
  Eigen::Array<double, kUpper, 1> agreement_ = Eigen::Array<double, kUpper, 1>::Zero();
  std::array<Vector6, kDegree + 1> gradient_{Vector6::Zero(), Vector6::Zero(), Vector6::Zero()};
};

}  // namespace dynemo
