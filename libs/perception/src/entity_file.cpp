#include <algorithm>
#include <cmath>

#include "dynemo/core/error.h"
#include "dynemo/core/yaml_place.h"
#include "dynemo/perception/entity_model.h"
#include "dynemo/perception/tag_family.h"

namespace dynemo {
namespace {

constexpr double kMaxUnitNormError = 1e-3;
/// Written corners are rounded, and repeat what pose and size say.
constexpr double kCornerTolerance_m = 1e-3;

using Place = YamlPlace;

Pose3 parsePose(const Place& place) {
  const auto v = place.vector<7>();
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (std::abs(q.norm() - 1.0) > kMaxUnitNormError) {
    place.fail("must be x y z qx qy qz qw with a unit quaternion");
  }
  return {q, v.head<3>()};
}

Vector3 parseDirection(const Place& place) {
  const Vector3 v = place.vector<3>();
  if (std::abs(v.norm() - 1.0) > kMaxUnitNormError) place.fail("must be a unit vector");
  return v.normalized();
}

void checkCorners(const Place& place, const TagModel& tag) {
  place.expectSequence(4);
  const auto expected = tag.corners();
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Place corner = place.at(i);
    if ((corner.vector<3>() - expected[i]).norm() > kCornerTolerance_m) {
      corner.fail("contradicts the tag's pose and size");
    }
  }
}

TagModel parseTag(const Place& unnamed, int family_size) {
  unnamed.expectMap({"id", "size", "side", "pose", "corners"});
  TagModel tag;
  const Place id = unnamed.at("id");
  tag.tag_id = id.as<int>("an integer");
  if (tag.tag_id < 0 || tag.tag_id >= family_size) {
    id.fail("must be in [0, " + std::to_string(family_size - 1) + "], the ids of the tag family");
  }
  const Place place = unnamed.named("tag " + std::to_string(tag.tag_id));
  tag.size_m = place.at("size").number();
  if (!(tag.size_m > 0.0)) place.at("size").fail("must be > 0");
  if (place.has("side")) place.at("side").word();
  tag.T_entity_tag = parsePose(place.at("pose"));
  if (place.has("corners")) checkCorners(place.at("corners"), tag);
  return tag;
}

SemanticClass parseClass(const Place& place) {
  const std::string name = place.word();
  if (name == "object") return SemanticClass::kObject;
  if (name == "agent") return SemanticClass::kAgent;
  place.fail("must be object or agent");
}

void parseTags(const Place& place, int family_size, EntityModel& model) {
  if (!place.has("tags")) return;
  const Place tags = place.at("tags");
  tags.expectSequence();
  for (std::size_t i = 0; i < tags.size(); ++i) {
    model.tags.push_back(parseTag(tags.at(i), family_size));
  }
}

EntityModel parseEntity(const Place& unnamed, int family_size) {
  unnamed.expectMap(
      {"id", "name", "class", "model", "motion_model", "origin_z", "prior_direction", "tags"});
  EntityModel model;
  model.id.value = unnamed.at("id").as<std::int64_t>("an integer");
  const std::string id_text = std::to_string(model.id.value);
  const Place place = unnamed.named("entity " + id_text);
  if (model.id.value < 0) place.at("id").fail("must be ≥ 0");
  model.semantic_class = parseClass(place.at("class"));
  const std::string kind =
      place.has("model") ? place.at("model").word() : semanticClassName(model.semantic_class);
  model.name = place.has("name") ? place.at("name").word() : kind + " " + id_text;
  if (place.has("motion_model")) model.motion_model = place.at("motion_model").word();
  if (place.has("origin_z")) model.origin_height_m = place.at("origin_z").number();
  if (place.has("prior_direction")) {
    model.direction_entity = parseDirection(place.at("prior_direction"));
  }
  parseTags(place, family_size, model);
  return model;
}

int familySize(const Place& top, const std::string& family) {
  try {
    return tagFamilySize(*makeTagFamily(family));
  } catch (const ConfigError& error) {
    top.at("tag_family").fail(std::string("is an ") + error.what());
  }
}

}  // namespace

EntityModels EntityModels::load(const std::filesystem::path& file) {
  const Place top = YamlPlace::file(file);
  if (top.isNull()) top.fail("is empty; for no entities write 'entities: []'");
  top.expectMap({"tag_family", "entities"});
  const std::string family =
      top.has("tag_family") ? top.at("tag_family").word() : EntityModels().tagFamily();
  const int family_size = familySize(top, family);
  const Place entities = top.at("entities");
  entities.expectSequence();
  std::vector<EntityModel> models;
  for (std::size_t i = 0; i < entities.size(); ++i) {
    models.push_back(parseEntity(entities.at(i), family_size));
  }
  try {
    return EntityModels(std::move(models), family);
  } catch (const ConfigError& error) {
    throw ConfigError(file.string() + ": " + error.what());
  }
}

}  // namespace dynemo
