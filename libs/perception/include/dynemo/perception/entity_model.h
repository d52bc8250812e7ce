// The entity file: which tags belong to which agent or object, and what is known of its motion.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/ids.h"
#include "dynemo/core/se3.h"
#include "dynemo/graph/node_entity.h"

namespace dynemo {

struct TagModel {
  int tag_id = 0;
  double size_m = 0.0;  ///< side of the black square
  /// libapriltag's tag frame: seen upright from the front, x right, y down, z into the tag.
  Pose3 T_entity_tag;
  /// In the entity frame, in the order of apriltag_detection_t::p.
  std::array<Vector3, 4> corners() const;
};

struct EntityModel {
  EntityId id{};
  std::string name;  ///< for people; "<model or class> <id>" when the file gives none
  SemanticClass semantic_class = SemanticClass::kObject;
  /// Name of a registered motion model; empty: the default of the class.
  std::string motion_model;
  /// Height of the origin over the floor, when known [m].
  std::optional<double> origin_height_m;
  /// Unit vector of a known straight motion, in the entity frame (agents).
  std::optional<Vector3> direction_entity;
  std::vector<TagModel> tags;
};

/// All entities of a place. Value type; lookups are by tag or entity id.
class EntityModels {
 public:
  EntityModels() = default;
  explicit EntityModels(std::vector<EntityModel> models, std::string tag_family = "tag36h11");

  /// Reads the YAML format described in share/doc/conventions.md. Throws ConfigError naming file, entity, key and
  /// constraint: malformed or empty file, unknown key or class, duplicate id, size ≤ 0, bad pose.
  static EntityModels load(const std::filesystem::path& file);

  const std::string& tagFamily() const { return tag_family_; }
  const std::vector<EntityModel>& all() const { return models_; }
  bool empty() const { return models_.empty(); }
  const EntityModel* findEntity(EntityId id) const;
  /// The entity that carries the tag and the tag itself, or nullptrs.
  std::pair<const EntityModel*, const TagModel*> findTag(int tag_id) const;

 private:
  std::string tag_family_ = "tag36h11";
  std::vector<EntityModel> models_;
  std::map<EntityId, std::size_t> by_entity_;
  std::map<int, std::pair<std::size_t, std::size_t>> by_tag_;
};

}  // namespace dynemo
