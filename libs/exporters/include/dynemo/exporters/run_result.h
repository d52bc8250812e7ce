#pragma once

#include <map>
#include <span>
#include <vector>

#include "dynemo/graph/session.h"

namespace dynemo {

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

/// A stored session as the run that wrote it; valid while the session is.
inline RunResult resultOf(const Session& session) {
  return {session.graph, session.frames, session.entity_covariances,
          session.keyframes_without_closures, &session.plane_covariances};
}

}  // namespace dynemo
