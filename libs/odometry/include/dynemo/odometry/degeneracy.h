// Directions in which a registration problem says nothing.
#pragma once

#include "dynemo/core/se3.h"

namespace dynemo {

/// The split of a 6-D space of small motions into observed directions and the others.
struct Degeneracy {
  /// Orthonormal columns, the unobserved directions first removed from `projector`.
  Eigen::Matrix<double, 6, Eigen::Dynamic> directions = Eigen::Matrix<double, 6, 0>();
  /// Projects onto the observed directions.
  Matrix6 projector = Matrix6::Identity();
  /// The smallest eigenvalue.
  double smallest_share = 0.0;

  bool any() const { return directions.cols() > 0; }
};

/// In coordinates whose norm is the root mean square displacement of the points, the eigenvalues of
/// the mean Hessian are the shares of the displacement's square along the normals, up to 1 (after
/// Zhang, Kaess, Singh, "On degeneracy of optimization-based state estimation problems", ICRA
/// 2016). Directions with a share below `min_share` are unobserved; 0 takes all as observed.
Degeneracy findDegeneracy(const Matrix6& mean_hessian, double min_share);

}  // namespace dynemo
