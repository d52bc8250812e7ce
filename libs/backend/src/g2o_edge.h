// g2o's own error of EDGE_SE3:QUAT: what its programs, and the published minima, minimise.
#pragma once

#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/node.h"

namespace dynemo::backend {

/// e = [t; q_xyz] of Z⁻¹ X₁⁻¹ X₂ with q_w ≥ 0, and the information as the file has it.
class G2oEdge : public CEdgeLoopClosure {
 public:
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override {
    const Pose3 X1 = CNodePose::poseFromState(states[0]), X2 = CNodePose::poseFromState(states[1]);
    const Pose3 X12 = X1.inverse() * X2;
    const Pose3 E = T_1_2.inverse() * X12;
    const Eigen::Quaterniond q = E.quaternion();
    e.resize(6);
    e << E.t, q.vec();
    if (!J) return;
    // q ⊗ [1, δ/2]: the vector part moves by (w I + [q]ₓ) δ/2.
    const Matrix3 half = 0.5 * (q.w() * Matrix3::Identity() + skew(q.vec()));
    for (int i = 0; i < 2; ++i) (*J)[i].setZero(6, 6);
    (*J)[0].topLeftCorner<3, 3>() = -T_1_2.R.transpose();
    (*J)[0].topRightCorner<3, 3>() = T_1_2.R.transpose() * skew(X12.t);
    (*J)[0].bottomRightCorner<3, 3>() = -half * X12.R.transpose();
    (*J)[1].topLeftCorner<3, 3>() = E.R;
    (*J)[1].bottomRightCorner<3, 3>() = half;
  }
};

}  // namespace dynemo::backend
