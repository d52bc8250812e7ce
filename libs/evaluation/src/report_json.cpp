#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dynemo/evaluation/run_report.h"

namespace dynemo {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / std::numbers::pi;

/// JSON knows no NaN.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json toJson(const Statistics& s, double scale = 1.0) {
  return {{"rmse", number(scale * s.rmse)},
          {"mean", number(scale * s.mean)},
          {"median", number(scale * s.median)},
          {"std", number(scale * s.std)},
          {"min", number(scale * s.min)},
          {"max", number(scale * s.max)},
          {"count", s.count}};
}

Json toJson(const PoseErrorStatistics& s) {
  return {{"translation_m", toJson(s.translation_m)},
          {"rotation_deg", toJson(s.rotation_rad, kDegrees)}};
}

Json toJson(const RelativePoseErrors& s) {
  return toJson(PoseErrorStatistics{s.translation_m, s.rotation_rad});
}

Json toJson(const PoseError& error) {
  return {{"translation_m", error.translation_m}, {"rotation_deg", kDegrees * error.rotation_rad}};
}

Json toJson(const Pose3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  return {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json toJson(const TrajectoryReport& report) {
  return {{"ate_m", toJson(report.ate_m)},
          {"rpe_1m", toJson(report.per_meter)},
          {"rpe_frame", toJson(report.per_frame)},
          {"T_reference_estimate", toJson(report.T_reference_estimate)}};
}

Json toJson(const DetectionCounts& c) {
  return {{"true_positives", c.true_positives},
          {"false_positives", c.false_positives},
          {"false_negatives", c.false_negatives},
          {"precision", c.precision()},
          {"recall", c.recall()},
          {"f1", c.f1()}};
}

Json toJson(const NeesSummary& s) {
  return {{"count", s.count},
          {"mean", number(s.mean)},
          {"degrees_of_freedom", 6},
          {"probability", s.probability},
          {"share_inside", number(s.share_inside)}};
}

Json classJson(const EntityReport& report, SemanticClass semantic_class,
               const MotionErrors& motions) {
  return {{"first", toJson(firstErrors(report.errors, semantic_class))},
          {"final", toJson(finalErrors(report.errors, semantic_class))},
          {"motion_error", toJson(motions.me)},
          {"relative_motion_error", toJson(motions.rme)},
          {"nees", toJson(neesSummary(report.errors, semantic_class))}};
}

Json perEntityJson(const EntityErrors& errors) {
  Json list = Json::array();
  for (const auto& [id, entity] : errors.entities) {
    list.push_back({{"entity_id", id.value},
                    {"class", semanticClassName(entity.semantic_class)},
                    {"name", entity.name},
                    {"first", toJson(entity.first)},
                    {"final", toJson(entity.final)}});
  }
  return list;
}

Json placementsJson(const EntityErrors& errors) {
  Json list = Json::array();
  for (const PlacementError& placement : errors.placements) {
    list.push_back({{"entity_id", placement.entity.value},
                    {"placement", placement.placement},
                    {"nodes", placement.nodes},
                    {"last", toJson(placement.last)},
                    {"median", toJson(placement.median)}});
  }
  return list;
}

Json changesJson(const ChangeReport& changes) {
  Json objects = Json::array();
  for (const ObjectChange& change : changes.objects) {
    objects.push_back({{"entity_id", change.entity.value},
                       {"truly_moved", change.truly_moved},
                       {"reported_moved", change.reported_moved}});
  }
  return {{"objects", objects},
          {"moved_by_object", toJson(changes.by_object)},
          {"moved_by_observation", toJson(changes.by_observation)},
          {"objects_at_end", toJson(changes.objects_at_end)}};
}

Json toJson(const LoopReport& loops) {
  return {{"closures", loops.closures},
          {"right", loops.right},
          {"precision", loops.precision()},
          {"closable", loops.closable},
          {"recalled", loops.recalled},
          {"recall", number(loops.recall())},
          {"removed", loops.removed},
          {"removed_right", loops.removed_right},
          {"without_truth", loops.without_truth},
          {"errors", toJson(loops.errors)}};
}

Json toJson(const EntityReport& report) {
  return {
      {"nodes", report.errors.nodes.size()},
      {"nodes_without_truth", report.errors.without_truth},
      {"objects", classJson(report, SemanticClass::kObject, report.object_motions)},
      {"object_placements",
       {{"last", toJson(placementErrors(report.errors))}, {"each", placementsJson(report.errors)}}},
      {"agents", classJson(report, SemanticClass::kAgent, report.agent_motions)},
      {"each_entity", perEntityJson(report.errors)},
      {"changes", changesJson(report.changes)}};
}

}  // namespace

std::string reportJson(const RunReport& report) {
  Json json = {{"run", report.run}, {"trajectory", toJson(report.trajectory)}};
  if (report.keyframes) json["keyframes"] = toJson(*report.keyframes);
  if (report.odometry) json["odometry"] = toJson(*report.odometry);
  if (report.loops) json["loops"] = toJson(*report.loops);
  if (report.entities) json["entities"] = toJson(*report.entities);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace dynemo
