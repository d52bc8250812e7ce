#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <set>
#include <sstream>
#include <string_view>

#include "dynemo/core/error.h"
#include "dynemo/perception/entity_model.h"
#include "dynemo/perception/tag_family.h"

namespace dynemo {
namespace {

constexpr double kMaxUnitNormError = 1e-3;
/// Written corners are rounded, and repeat what pose and size say.
constexpr double kCornerTolerance_m = 1e-3;

/// A node together with the words that say where it is: "file: entity 3: tag 46: size".
class Place {
 public:
  Place(YAML::Node node, std::string where) : node_(std::move(node)), where_(std::move(where)) {}

  [[noreturn]] void fail(const std::string& constraint) const {
    std::string value;
    if (node_.IsDefined() && node_.IsScalar()) value = " '" + node_.Scalar() + "'";
    throw ConfigError(where_ + ":" + value + " " + constraint);
  }

  const std::string& where() const { return where_; }
  bool isNull() const { return !node_.IsDefined() || node_.IsNull(); }
  std::size_t size() const { return node_.size(); }

  Place named(const std::string& name) const { return {node_, where_ + ": " + name}; }
  bool has(const char* key) const { return node_[key].IsDefined(); }
  Place at(const char* key) const {
    if (!has(key)) fail(std::string("lacks the key '") + key + "'");
    return {node_[key], where_ + ": " + key};
  }
  Place at(std::size_t i) const { return {node_[i], where_ + ": element " + std::to_string(i)}; }

  /// A mapping with no other and no repeated keys.
  void expectMap(std::initializer_list<std::string_view> allowed) const {
    if (isNull() || !node_.IsMap()) fail("must be a mapping");
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) fail("has a key that is not a word");
      const std::string key = entry.first.Scalar();
      if (std::find(allowed.begin(), allowed.end(), key) == allowed.end()) {
        fail("unknown key '" + key + "'");
      }
      if (!seen.insert(key).second) fail("key '" + key + "' is given twice");
    }
  }

  void expectSequence(std::optional<std::size_t> size = std::nullopt) const {
    if (isNull() || !node_.IsSequence()) fail("must be a list");
    if (size && node_.size() != *size) {
      fail("must have " + std::to_string(*size) + " elements, has " + std::to_string(node_.size()));
    }
  }

  template <class T>
  T as(const char* kind) const {
    if (!node_.IsDefined() || !node_.IsScalar()) fail(std::string("must be ") + kind);
    try {
      return node_.as<T>();
    } catch (const YAML::Exception&) {
      fail(std::string("must be ") + kind);
    }
  }

  double number() const {
    const double value = as<double>("a number");
    if (!std::isfinite(value)) fail("must be finite");
    return value;
  }

  std::string word() const {
    const std::string value = as<std::string>("a text");
    if (value.empty()) fail("must not be empty");
    return value;
  }

  template <int N>
  Eigen::Matrix<double, N, 1> vector() const {
    expectSequence(N);
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = at(static_cast<std::size_t>(i)).number();
    return v;
  }

 private:
  YAML::Node node_;
  std::string where_;
};

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

YAML::Node readYaml(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  if (!in || std::filesystem::is_directory(file) || !(text << in.rdbuf())) {
    throw ConfigError(file.string() + ": cannot be read or is empty");
  }
  try {
    return YAML::Load(text.str());
  } catch (const YAML::Exception& error) {
    throw ConfigError(file.string() + ": not YAML: " + error.what());
  }
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
  const Place top(readYaml(file), file.string());
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
