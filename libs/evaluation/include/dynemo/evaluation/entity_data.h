// The entities of a run and their ground truth, as tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/ids.h"
#include "dynemo/evaluation/trajectory.h"
#include "dynemo/graph/node_entity.h"

namespace dynemo {

/// One observation of one entity, as a run's entities.csv has it.
struct EntityEstimate {
  NodeId node{};
  EntityId entity{};
  SemanticClass semantic_class = SemanticClass::kObject;
  std::string name;
  Stamp stamp;
  /// The run's verdict: displaced since the previous observation.
  bool moved = false;
  Pose3 T_map_entity;
  /// Estimate when the node was created.
  Pose3 T_map_entity_first;
  /// Of T_map_entity's right tangent; empty when the run computed none.
  std::optional<Matrix6> covariance;
};

/// Reads a run's entities.csv; columns are found by their names in the first line. Throws DataError
/// naming file and line.
std::vector<EntityEstimate> readEntityEstimates(const std::filesystem::path& file);

struct EntityTruth {
  SemanticClass semantic_class = SemanticClass::kObject;
  /// T_world_entity; between consecutive poses it moves linearly.
  Trajectory poses;
};

using EntityTruths = std::map<EntityId, EntityTruth>;

/// Reads "entity_id,class,timestamp,x,y,z,qx,qy,qz,qw" with a first line of these names in any
/// order. Throws DataError naming file and line.
EntityTruths readEntityTruths(const std::filesystem::path& file);

}  // namespace dynemo
