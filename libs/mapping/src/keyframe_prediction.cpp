#include "dynemo/mapping/keyframe_prediction.h"

#include <algorithm>
#include <stdexcept>

namespace dynemo {

KeyframePrediction::KeyframePrediction(const CSceneGraph& graph, const Pose3& T_map_base,
                                       const Matrix6& odometry_covariance,
                                       std::vector<NodeId> nodes, const MatrixX& joint)
    : T_map_base_(T_map_base), nodes_(std::move(nodes)), joint_(joint) {
  const CNodeKeyframe& last = *graph.keyframes().back();
  const Matrix6 A = composeJacobianLeft(last.T_map_base().inverse() * T_map_base);
  joint_.topRows<6>() = A * joint_.topRows<6>();
  joint_.leftCols<6>() = joint_.leftCols<6>() * A.transpose();
  joint_.topLeftCorner<6, 6>() += odometry_covariance;
  covariance_ = joint_.topLeftCorner<6, 6>();
  Eigen::Index at = 6;
  for (const NodeId node : nodes_) {
    offset_.push_back(at);
    size_.push_back(graph.getNode<CNodeBase>(node).tangentSize());
    at += size_.back();
  }
}

void KeyframePrediction::widen(const Matrix6& covariance) {
  joint_.topLeftCorner<6, 6>() += covariance;
  covariance_ += covariance;
}

bool KeyframePrediction::knows(NodeId node) const {
  return std::find(nodes_.begin(), nodes_.end(), node) != nodes_.end();
}

MatrixX KeyframePrediction::jointWith(std::initializer_list<NodeId> nodes) const {
  std::vector<Eigen::Index> index;
  for (Eigen::Index i = 0; i < 6; ++i) index.push_back(i);
  for (const NodeId node : nodes) {
    const auto it = std::find(nodes_.begin(), nodes_.end(), node);
    if (it == nodes_.end()) throw std::out_of_range("a node that the prediction does not know");
    const auto k = static_cast<std::size_t>(it - nodes_.begin());
    for (Eigen::Index i = 0; i < size_[k]; ++i) index.push_back(offset_[k] + i);
  }
  return joint_(index, index);
}

}  // namespace dynemo
