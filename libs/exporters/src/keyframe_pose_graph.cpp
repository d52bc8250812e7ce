#include "keyframe_pose_graph.h"

#include <Eigen/Dense>

#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

RelativePose inverted(const RelativePose& edge) {
  // (T ⊞ d)⁻¹ = T⁻¹ ⊞ J d, hence Ω' = J⁻ᵀ Ω J⁻¹.
  const Pose3& T = edge.T_1_2;
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = -T.R;
  J.topRightCorner<3, 3>() = -T.R * skew(T.R.transpose() * T.t);
  J.bottomRightCorner<3, 3>() = -T.R;
  const Matrix6 J_inv = J.inverse();
  const Matrix6 information = J_inv.transpose() * edge.information * J_inv;
  return {T.inverse(), 0.5 * (information + information.transpose())};
}

RelativePose fused(const RelativePose& a, const RelativePose& b) {
  const Matrix6 information = a.information + b.information;
  const Vector6 step = information.ldlt().solve(b.information * local(a.T_1_2, b.T_1_2));
  return {a.T_1_2.retract(step), information};
}

std::map<std::pair<NodeId, NodeId>, RelativePose> keyframePoseGraph(const CSceneGraph& graph) {
  std::map<std::pair<NodeId, NodeId>, RelativePose> merged;
  for (const auto& slot : graph.edgeSlots()) {
    const auto* edge = dynamic_cast<const CEdgeRelativePose*>(slot.get());
    if (!edge) continue;
    const NodeId from = edge->nodes[0], to = edge->nodes[1];
    if (!graph.findNode<CNodeKeyframe>(from) || !graph.findNode<CNodeKeyframe>(to)) continue;
    const RelativePose measured{edge->T_1_2, edge->information()};
    if (const auto same = merged.find({from, to}); same != merged.end()) {
      same->second = fused(same->second, measured);
    } else if (const auto opposed = merged.find({to, from}); opposed != merged.end()) {
      opposed->second = fused(opposed->second, inverted(measured));
    } else {
      merged.emplace(std::pair(from, to), measured);
    }
  }
  return merged;
}

}  // namespace dynemo
