#pragma once

#include <filesystem>
#include <map>
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

/// A whole mapping session: the graph with its drift, the effective configuration, the keyframes'
/// clouds, the frames between the keyframes, and the uncertainty of entities and
/// planes.
struct Session {
  CSceneGraph graph;
  std::string config_yaml;
  std::vector<FramePose> frames = {};
  /// Marginal covariance of entity nodes' tangents, where computed.
  std::map<NodeId, Matrix6> entity_covariances = {};
  /// Marginal covariance of plane nodes' tangents, where computed.
  std::map<NodeId, Matrix3> plane_covariances = {};
  /// T_map_base of each keyframe as the graph has it without its loop closures; empty when there is
  /// none.
  std::vector<Pose3> keyframes_without_closures = {};
};

/// Writes the session into a folder (created when missing): graph.bin, poses.bin, config.yaml,
/// clouds/NNNNNN.bin. Saving what was loaded gives the same bytes. Throws DataError, leaving an
/// earlier graph.bin in place, when it cannot be written.
void saveSession(const Session& session, const std::filesystem::path& folder);

/// Reads it back, clouds included; a folder without poses.bin gives neither frames nor
/// covariances. Throws DataError naming the file that is missing or damaged.
Session loadSession(const std::filesystem::path& folder);

/// The session of a run's output folder (`session` inside it), or of a session folder itself. Where
/// no frames were stored, the keyframes stand for them. Throws DataError when there is none.
Session loadRunSession(const std::filesystem::path& folder);

}  // namespace dynemo
