#include "dynemo/perception/entity_model.h"

#include "dynemo/core/error.h"

namespace dynemo {

std::array<Vector3, 4> TagModel::corners() const {
  const double h = 0.5 * size_m;
  return {T_entity_tag * Vector3(-h, h, 0.0), T_entity_tag * Vector3(h, h, 0.0),
          T_entity_tag * Vector3(h, -h, 0.0), T_entity_tag * Vector3(-h, -h, 0.0)};
}

EntityModels::EntityModels(std::vector<EntityModel> models, std::string tag_family)
    : tag_family_(std::move(tag_family)), models_(std::move(models)) {
  for (std::size_t i = 0; i < models_.size(); ++i) {
    if (!by_entity_.emplace(models_[i].id, i).second) {
      throw ConfigError("entity " + std::to_string(models_[i].id.value) + ": id is used twice");
    }
    for (std::size_t k = 0; k < models_[i].tags.size(); ++k) {
      const int tag_id = models_[i].tags[k].tag_id;
      const auto [it, inserted] = by_tag_.emplace(tag_id, std::pair(i, k));
      if (!inserted) {
        throw ConfigError("tag " + std::to_string(tag_id) + ": on entity " +
                          std::to_string(models_[it->second.first].id.value) + " and on entity " +
                          std::to_string(models_[i].id.value));
      }
    }
  }
}

const EntityModel* EntityModels::findEntity(EntityId id) const {
  const auto it = by_entity_.find(id);
  return it == by_entity_.end() ? nullptr : &models_[it->second];
}

std::pair<const EntityModel*, const TagModel*> EntityModels::findTag(int tag_id) const {
  const auto it = by_tag_.find(tag_id);
  if (it == by_tag_.end()) return {nullptr, nullptr};
  const EntityModel& model = models_[it->second.first];
  return {&model, &model.tags[it->second.second]};
}

}  // namespace dynemo
