#pragma once

#include <vector>

#include "dynemo/core/noise.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// Where a keyframe in the making is, and how its error hangs together with that of mapped nodes:
/// the joint marginal of the last keyframe and the nodes, carried over the odometry since.
class KeyframePrediction {
 public:
  /// `joint`: covariance of the tangents of the last keyframe, then of `nodes`, as
  /// Optimizer::marginalCovariance gives it. `odometry_covariance`: of the right tangent of the
  /// motion since the last keyframe.
  KeyframePrediction(const CSceneGraph& graph, const Pose3& T_map_base,
                     const Matrix6& odometry_covariance, std::vector<NodeId> nodes,
                     const MatrixX& joint);

  /// Adds to the uncertainty of the motion since the last keyframe, right tangent.
  void widen(const Matrix6& covariance);

  const Pose3& T_map_base() const { return T_map_base_; }
  bool knows(NodeId node) const;
  /// Of the right tangent of the new keyframe.
  const Matrix6& covariance() const { return covariance_; }
  /// Joint covariance of the tangents of the new keyframe and the given nodes, in that order.
  /// Throws std::out_of_range for a node that was not asked for.
  MatrixX jointWith(std::initializer_list<NodeId> nodes) const;

 private:
  Pose3 T_map_base_;
  Matrix6 covariance_;
  std::vector<NodeId> nodes_;
  std::vector<Eigen::Index> offset_, size_;
  MatrixX joint_;  ///< with the new keyframe in place of the last one
};

}  // namespace dynemo
