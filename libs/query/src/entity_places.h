// The space that entities fill, and where they are or may be at a time.
#pragma once

#include <map>
#include <vector>

#include "dynemo/query/entity_extent.h"
#include "dynemo/query/point_owners.h"
#include "dynemo/query/query_params.h"
#include "dynemo/query/stays.h"
#include "dynemo/query/structure_params.h"

namespace dynemo {

/// In the entity's frame: a box, or an upright cylinder (about z) for bodies that turn, swing their
/// limbs and are seen from one side at a time.
struct EntityVolume {
  Extent extent;
  bool cylinder = false;
  Vector2 axis = Vector2::Zero();
  double radius_m = 0.0;

  bool contains(const Vector3& p_entity) const;
  /// Of a ball around the entity's origin that holds it.
  double reach_m() const;
};

/// What the entity's fragments show of its size, and a margin; empty when there are too few points
/// to tell. Fragments that hold something else as well do not count.
std::optional<EntityVolume> volumeOf(const CSceneGraph& graph, const EntityTrack& track,
                                     double margin_m);

struct EntityPlace {
  PlacedEntity placed;
  EntityVolume volume;
  double reach_m = 0.0;
};

class EntityPlaces {
 public:
  EntityPlaces(const CSceneGraph& graph, const std::map<NodeId, Matrix6>& covariances,
               const StructureParams& params, const QueryParams& query);

  /// Null when too little was seen of the entity to tell.
  const EntityVolume* volume(EntityId entity) const;
  /// Objects where they stand or may stand; both places while they are carried from one to the
  /// other.
  std::vector<EntityPlace> objectsAt(Stamp at) const;
  /// Agents that are seen at the time, or shortly before and shortly after it.
  std::vector<EntityPlace> agentsAt(Stamp at) const;

 private:
  struct Known {
    const EntityTrack* track;
    EntityVolume volume;
    std::vector<Stay> stays;  ///< of an object
  };
  EntityPlace placed(const Known& known, const Pose3& T_map_entity) const;

  std::vector<Known> objects_, agents_;
  double agent_gap_s_;
};

}  // namespace dynemo
