#include <nlohmann/json.hpp>

#include "dynemo/prep/inspection.h"

namespace dynemo {
namespace {

using Json = nlohmann::ordered_json;

Json stampJson(const std::optional<Stamp>& stamp) {
  return stamp ? Json(stamp->text()) : Json(nullptr);
}

template <class T>
Json optionalJson(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json poseJson(const Pose3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  return {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json cameraJson(const CameraInspection& c) {
  return {{"width", c.width},
          {"height", c.height},
          {"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"distortion", c.distortion},
          {"embedded", c.embedded},
          {"external", c.external},
          {"external_missing", c.external_missing}};
}

Json sensorJson(const SensorInspection& s) {
  Json json = {
      {"label", s.label},
      {"class", s.class_name},
      {"use", useText(s.use)},
      {"count", s.count},
      {"without_stamp", s.without_stamp},
      {"first", stampJson(s.first)},
      {"last", stampJson(s.last)},
      {"rate_hz", s.rate_hz()},
      {"gaps", s.gaps},
      {"longest_gap_s", s.longest_gap_s},
      {"longest_gap_at", stampJson(s.longest_gap_at)},
      {"jumps_back", s.jumps_back},
      {"clock_offset_s", s.clock_offset_s},
      {"other_clock", s.other_clock},
      {"clock_uncertainty_s", s.clock_tie ? Json(s.clock_tie->uncertainty_s) : Json(nullptr)},
      {"T_base_sensor", s.T_base_sensor ? poseJson(*s.T_base_sensor) : Json(nullptr)},
      {"pose_changes", s.pose_changes}};
  if (s.scan)
    json["scan"] = {{"min_points", s.scan->min_points},
                    {"max_points", s.scan->max_points},
                    {"mean_points", s.count > 0 ? static_cast<double>(s.scan->sum_points) /
                                                      static_cast<double>(s.count)
                                                : 0.0},
                    {"point_times", s.scan->point_times}};
  if (s.camera) json["camera"] = cameraJson(*s.camera);
  return json;
}

Json tagJson(const SurveyedTag& tag) {
  return {{"id", tag.id},
          {"sightings", tag.sightings},
          {"min_edge_px", tag.min_edge_px},
          {"max_edge_px", tag.max_edge_px},
          {"measured_size_m", optionalJson(tag.measured_size_m)},
          {"size_points", tag.size_points},
          {"speed_m_s", optionalJson(tag.speed_m_s)}};
}

}  // namespace

std::string inspectionJson(const Inspection& log) {
  Json json = {{"rawlog", log.rawlog.string()},
               {"runnable", log.runnable()},
               {"frames", log.frames},
               {"frames_with_odometry", log.frames_with_odometry},
               {"clocks", clockCount(log)},
               {"file_bytes", log.file_bytes},
               {"compressed", log.compressed},
               {"actions_and_frames", log.actions_and_frames},
               {"objects", log.objects},
               {"null_objects", log.null_objects},
               {"other_objects", log.other_objects},
               {"damage", log.damage},
               {"first", stampJson(log.first)},
               {"last", stampJson(log.last)}};
  json["sensors"] = Json::array();
  for (const SensorInspection& s : log.sensors) json["sensors"].push_back(sensorJson(s));
  json["images_searched"] = log.images_searched;
  json["tags"] = Json::array();
  for (const SurveyedTag& tag : log.tags) json["tags"].push_back(tagJson(tag));
  json["findings"] = Json::array();
  for (const Finding& f : log.findings)
    json["findings"].push_back({{"severity", severityText(f.severity)},
                                {"what", f.what},
                                {"fix", f.fix},
                                {"commands", f.commands}});
  if (const auto& trial = log.odometry_trial)
    json["odometry_trial"] = {
        {"scans", trial->scans}, {"followed", trial->followed}, {"warnings", trial->warnings}};
  json["ingest_warnings"] = log.ingest_warnings;
  // Labels are whatever bytes the log holds.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace dynemo
