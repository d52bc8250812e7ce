#include <nlohmann/json.hpp>

#include "answers.h"

namespace dynemo {

using Json = nlohmann::ordered_json;

namespace {

Json poseJson(const Pose3& T) {
  const auto q = T.quaternion();
  return {{"position_m", {T.t.x(), T.t.y(), T.t.z()}},
          {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

Json poseOrNull(const std::optional<Pose3>& T) { return T ? poseJson(*T) : Json(); }

/// Text, since doubles do not hold nanoseconds.
Json stampOrNull(const std::optional<Stamp>& stamp) { return stamp ? Json(stamp->text()) : Json(); }

Json covarianceOrNull(const std::optional<Matrix6>& covariance) {
  if (!covariance) return {};
  Json rows = Json::array();
  for (int r = 0; r < 6; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 6; ++c) row.push_back((*covariance)(r, c));
    rows.push_back(row);
  }
  return rows;
}

Json alternativeJson(const Whereabouts& w) {
  if (!w.alternative) return {};
  return {{"T_map_entity", poseJson(w.alternative->T_map_entity)},
          {"covariance", covarianceOrNull(w.alternative->covariance)},
          {"presence", w.alternative->presence}};
}

Json whereaboutsJson(const Whereabouts& w) {
  return {{"entity", w.entity.value},
          {"name", w.name},
          {"class", semanticClassName(w.semantic_class)},
          {"T_map_entity", poseJson(w.T_map_entity)},
          {"covariance", covarianceOrNull(w.covariance)},
          {"last_seen", stampOrNull(w.last_seen)},
          {"next_seen", stampOrNull(w.next_seen)},
          {"presence", w.presence},
          {"alternative", alternativeJson(w)},
          {"carried", w.carried()}};
}

std::string text(const Json& json) { return json.dump(2) + "\n"; }

}  // namespace

std::string whereJson(const Whereabouts& w, Stamp at) {
  Json json = {{"at", at.text()}};
  json.update(whereaboutsJson(w));
  return text(json);
}

std::string movedJson(const std::vector<Move>& moves) {
  Json list = Json::array();
  for (const Move& m : moves) {
    list.push_back({{"entity", m.entity.value},
                    {"name", m.name},
                    {"T_map_before", poseJson(m.T_map_before)},
                    {"T_map_after", poseJson(m.T_map_after)},
                    {"distance_m", m.distance()},
                    {"last_before", m.last_before.text()},
                    {"first_after", m.first_after.text()},
                    {"probability", m.probability}});
  }
  return text({{"moves", list}});
}

std::string nearJson(const std::vector<Whereabouts>& found, const Vector3& p_map, Stamp at) {
  Json list = Json::array();
  for (const Whereabouts& w : found) {
    Json entry = whereaboutsJson(w);
    entry["distance_m"] = (w.T_map_entity.t - p_map).norm();
    list.push_back(entry);
  }
  return text({{"at", at.text()}, {"entities", list}});
}

std::string trackJson(const std::vector<Sighting>& track, const Whereabouts& entity) {
  Json list = Json::array();
  for (const Sighting& s : track) {
    list.push_back({{"stamp", s.stamp.text()},
                    {"T_map_entity", poseJson(s.T_map_entity)},
                    {"covariance", covarianceOrNull(s.covariance)},
                    {"moved", s.moved}});
  }
  return text({{"entity", entity.entity.value},
               {"name", entity.name},
               {"class", semanticClassName(entity.semantic_class)},
               {"track", list}});
}

std::string entitiesJson(const std::vector<Whereabouts>& all, Stamp at) {
  Json list = Json::array();
  for (const Whereabouts& w : all) list.push_back(whereaboutsJson(w));
  return text({{"at", at.text()}, {"entities", list}});
}

std::string differenceJson(const SessionDifference& difference) {
  Json agreeing = Json::array(), objects = Json::array();
  for (const EntityId id : difference.agreeing) agreeing.push_back(id.value);
  for (const ObjectDifference& d : difference.objects) {
    objects.push_back({{"entity", d.entity.value},
                       {"name", d.name},
                       {"change", changeName(d.change)},
                       {"T_mapB_entityA", poseOrNull(d.T_mapB_entityA)},
                       {"T_mapB_entityB", poseOrNull(d.T_mapB_entityB)},
                       {"certainty", d.certainty}});
  }
  return text({{"T_mapB_mapA", poseJson(difference.T_mapB_mapA)},
               {"agreeing", agreeing},
               {"common", difference.common},
               {"rms_m", difference.rms_m},
               {"objects", objects}});
}

}  // namespace dynemo
