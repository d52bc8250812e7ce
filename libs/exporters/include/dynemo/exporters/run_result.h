#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "dynemo/graph/session.h"
#include "dynemo/query/point_owners.h"

namespace dynemo {

/// What one exporter found out and the next one need not; not for several threads.
struct SharedFindings {
  StructureParams structure;
  QueryParams query;
  std::unique_ptr<const PointOwners> owners;
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
  /// Of this run as it is; copies share it.
  std::shared_ptr<SharedFindings> findings = std::make_shared<SharedFindings>();
};

/// Whose the points of the run's scans are, judged when it is first asked for. Valid until it is
/// asked for with other parameters.
const PointOwners& pointOwners(const RunResult& run, const StructureParams& structure,
                               const QueryParams& query);

/// A stored session as the run that wrote it; valid while the session is.
inline RunResult resultOf(const Session& session) {
  return {session.graph, session.frames, session.entity_covariances,
          session.keyframes_without_closures, &session.plane_covariances};
}

}  // namespace dynemo
