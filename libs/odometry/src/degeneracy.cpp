#include "dynemo/odometry/degeneracy.h"

#include <Eigen/Eigenvalues>

namespace dynemo {

Degeneracy findDegeneracy(const Matrix6& mean_hessian, double min_share) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(mean_hessian);
  Eigen::Index weak = 0;  // eigenvalues ascend
  while (min_share > 0.0 && weak < 6 && !(solver.eigenvalues()[weak] >= min_share)) ++weak;
  Degeneracy result;
  result.directions = solver.eigenvectors().leftCols(weak);
  result.projector -= result.directions * result.directions.transpose();
  result.smallest_share = solver.eigenvalues()[0];
  return result;
}

}  // namespace dynemo
