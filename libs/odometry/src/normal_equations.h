// Sums of the Gauss–Newton equations of one scan's registration.
//
// A world-axes perturbation (dt, dθ) of the pose and (dv, dω) of the twist moves a point at lever
// arm s from the base and time τ from the reference by A dt_dθ + τ A dv_dω with A = [I, −[s]×]. The
// residual e = q − p is weighted with
//   M = w (k b bᵀ + ε I),
// b the bisector of the two normals: a row a = [b; s×b] along it and the small isotropic part ε.
#pragma once

#include <array>

#include "dynemo/core/se3.h"

namespace dynemo {

/// One correspondence, weighted.
struct WeightedResidual {
  Vector3 e, s, b;
  double along_normal;      ///< b · e
  double weight_normal;     ///< w k
  double weight_isotropic;  ///< w ε
  double tau_s;
};

class NormalEquations {
 public:
  explicit NormalEquations(bool timed) : orders_(timed ? 3 : 1) {}

  void add(const WeightedResidual& r);
  void add(const NormalEquations& other);

  /// Σ τᵏ AᵀMA without and with the isotropic part, Σ τᵏ AᵀM e.
  Matrix6 normalHessian(int order) const;
  Matrix6 hessian(int order) const;
  Vector6 gradient(int order) const;

  std::size_t matched = 0, inliers = 0;
  double weight_sum = 0.0;
  /// Σ w k (b·e)² and Σ w k |s|².
  double squared_residuals = 0.0, squared_levers = 0.0;

 private:
  static constexpr int kUpper = 21;
  int orders_;
  std::array<std::array<double, kUpper>, 3> normal_{};
  std::array<Vector6, 3> gradient_{Vector6::Zero(), Vector6::Zero(), Vector6::Zero()};
  /// Σ wε τᵏ {1, s, s sᵀ}.
  std::array<double, 3> mass_{};
  std::array<Vector3, 3> moment_{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  std::array<Matrix3, 3> inertia_{Matrix3::Zero(), Matrix3::Zero(), Matrix3::Zero()};
};

}  // namespace dynemo
