#pragma once

#include <string>

#include "dynemo/core/point_cloud.h"
#include "dynemo/graph/node.h"

namespace dynemo {

/// Semantic class of an entity: agents move by themselves, objects are moved.
enum class SemanticClass : std::uint8_t { kObject = 0, kAgent = 1 };

const char* semanticClassName(SemanticClass c);

/// One observation of one entity at one keyframe: state T_map_entity ∈ SE(3) at the observation's
/// stamp.
class CNodeEntity : public CNodePose {
  DEFINE_SERIALIZABLE(CNodeEntity, dynemo)
 public:
  EntityId entity{};
  std::string name;
  SemanticClass semantic_class = SemanticClass::kObject;
  NodeId keyframe{};
  /// When the entity was seen (the camera's stamp, which need not be the keyframe's).
  Stamp stamp;
  /// Whether the motion model found the entity displaced since its previous observation.
  bool moved = false;
  /// The entity's points, as indices into the keyframe's scan; empty when it has none.
  PointIndices fragment;

  const Pose3& T_map_entity() const { return T_map_node; }
  const char* kind() const override { return "entity"; }
};

}  // namespace dynemo
