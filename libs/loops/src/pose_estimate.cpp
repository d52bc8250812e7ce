#include "dynemo/loops/pose_estimate.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

namespace dynemo {

PoseEstimate compose(const PoseEstimate& a_b, const PoseEstimate& b_c) {
  const Matrix6 A = composeJacobianLeft(b_c.T);
  return {a_b.T * b_c.T, A * a_b.covariance * A.transpose() + b_c.covariance};
}

PoseEstimate inverse(const PoseEstimate& a_b) {
  const Pose3 T_b_a = a_b.T.inverse();
  const Matrix6 A = composeJacobianLeft(T_b_a);
  return {T_b_a, A * a_b.covariance * A.transpose()};
}

double squaredMahalanobis(const PoseEstimate& a, const PoseEstimate& b) {
  return squaredMahalanobis(VectorX(local(a.T, b.T)), MatrixX(a.covariance + b.covariance));
}

std::optional<PoseEstimate> fuse(std::span<const PoseEstimate> estimates) {
  constexpr int kIterations = 20;
  constexpr double kConverged = 1e-10;
  std::vector<Matrix6> information;
  for (const PoseEstimate& e : estimates) {
    const auto inverted = invertSpd(e.covariance);
    if (!inverted) return std::nullopt;
    information.push_back(*inverted);
  }
  if (estimates.empty()) return std::nullopt;

  PoseEstimate mean = estimates.front();
  for (int i = 0; i < kIterations; ++i) {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const Vector6 e = local(estimates[k].T, mean.T);
      Matrix6 J = Matrix6::Identity();
      J.topLeftCorner<3, 3>() = estimates[k].T.R.transpose() * mean.T.R;
      J.bottomRightCorner<3, 3>() = rightJacobianInverseSO3(e.tail<3>());
      H += J.transpose() * information[k] * J;
      g += J.transpose() * information[k] * e;
    }
    const auto covariance = invertSpd(H);
    if (!covariance) return std::nullopt;
    mean.covariance = *covariance;
    const Vector6 step = -(*covariance * g);
    mean.T = mean.T.retract(step);
    if (step.norm() < kConverged) break;
  }
  return mean;
}

double largestTranslationSigma(const Matrix6& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(covariance.topLeftCorner<3, 3>(),
                                                     Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues().maxCoeff()));
}

}  // namespace dynemo
