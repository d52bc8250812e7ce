// To whom the points of the scans belong: to the structure of the place, to an entity, or to
// something that only passed by.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "dynemo/core/noise.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/query/query_params.h"
#include "dynemo/query/structure_params.h"

namespace dynemo {

/// An entity at the place where it was in a scan.
struct PlacedEntity {
  EntityId entity{};
  SemanticClass semantic_class = SemanticClass::kObject;
  Pose3 T_map_entity;
};

/// Of the points of one scan.
struct ScanOwners {
  static constexpr std::int32_t kStructure = -1, kPassing = -2;
  /// Per point, an index into `entities`, or one of the above.
  std::vector<std::int32_t> owner;
  std::vector<PlacedEntity> entities;

  bool isStructure(std::size_t point) const { return owner[point] == kStructure; }
  const PlacedEntity* entity(std::size_t point) const {
    return owner[point] >= 0 ? &entities[static_cast<std::size_t>(owner[point])] : nullptr;
  }
};

/// Judges every scan of a map with the help of all others. In this order:
/// 1. A point of an entity's fragment is the entity's, unless it is outside of all that the other
///    fragments show of the entity.
/// 2. A point on a mapped floor, wall or ceiling is structure.
/// 3. A point inside the volume of an object that stands there, or may stand there, is the
///    object's: from when it was last seen elsewhere before until it is first seen elsewhere after.
/// 4. So is one of an agent that is seen shortly before and after, unless most other scans see
///    something there, too.
/// 5. A point at a place that other scans see through belongs to something that only passed by.
/// The time is linear in the points of all scans and in the places, each of which a bounded number
/// of scans looks at.
class PointOwners {
 public:
  PointOwners(const CSceneGraph& graph, const std::map<NodeId, Matrix6>& entity_covariances,
              const StructureParams& params = {}, const QueryParams& query = {});

  /// Of a keyframe of the graph; throws std::out_of_range when it had no scan.
  const ScanOwners& of(const CNodeKeyframe& keyframe) const { return scans_.at(keyframe.id); }

 private:
  std::map<NodeId, ScanOwners> scans_;
};

}  // namespace dynemo
