#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "dynemo/core/noise.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// One processed frame.
struct FramePose {
  Stamp stamp;
  Pose3 T_odom_base;
  Pose3 T_map_base;  ///< optimised
};

/// Everything a finished (or interrupted) run hands to the exporters. Not owned: valid while the
/// pipeline is.
struct RunResult {
  const CSceneGraph& graph;
  const std::vector<FramePose>& frames;
  /// Marginal covariance of entity nodes' tangents, where computed.
  const std::map<NodeId, Matrix6>& entity_covariances;
  /// T_map_base of each keyframe as the graph has it without its loop closures; empty when there is
  /// none, or when it was not asked for.
  std::span<const Pose3> keyframes_without_closures = {};
  /// Of plane nodes' tangents, when computed.
  const std::map<NodeId, Matrix3>* plane_covariances = nullptr;
};

}  // namespace dynemo
