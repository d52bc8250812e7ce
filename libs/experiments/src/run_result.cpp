#include "dynemo/experiments/run_result.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/evaluation/run_report.h"
#include "dynemo/experiments/csv_table.h"

namespace dynemo::experiments {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Json readJson(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw DataError(file.string() + ": cannot be read");
  try {
    return Json::parse(in);
  } catch (const Json::exception& error) {
    throw DataError(file.string() + ": " + error.what());
  }
}

void addEntities(const EntityErrors& errors, Stamp start, RunResult& result) {
  std::map<EntityId, std::vector<const EntityNodeError*>> tracks;
  for (const EntityNodeError& node : errors.nodes) {
    tracks[node.estimate.entity].push_back(&node);
    result.entity_samples.push_back(
        {static_cast<int>(node.estimate.entity.value),
         semanticClassName(node.estimate.semantic_class),
         secondsBetween(start, node.estimate.stamp),
         node.first.translation_m,
         node.first.rotation_rad * 180.0 / std::numbers::pi,
         {node.T_world_entity_estimated.t.x(), node.T_world_entity_estimated.t.y(),
          node.T_world_entity.t.x(), node.T_world_entity.t.y()}});
  }
  for (auto& [id, nodes] : tracks) {
    std::stable_sort(nodes.begin(), nodes.end(), [](const auto* a, const auto* b) {
      return a->estimate.stamp < b->estimate.stamp;
    });
    result.entities.push_back(
        {static_cast<int>(id.value), semanticClassName(nodes.front()->estimate.semantic_class),
         nodes.front()->first.translation_m, nodes.back()->final.translation_m});
  }
}

void addPath(const Trajectory& reference, const Trajectory& estimate, const Pose3& T_world_map,
             RunResult& result) {
  const std::size_t step = std::max<std::size_t>(1, estimate.size() / 1000);
  for (std::size_t i = 0; i < estimate.size(); i += step) {
    const auto truth = poseAt(reference, estimate[i].stamp);
    if (!truth) continue;
    const Vector3 p = T_world_map * estimate[i].T.t;
    result.path.push_back({p.x(), p.y(), truth->t.x(), truth->t.y()});
  }
}

void addOptimizations(const fs::path& file, RunResult& result) {
  const CsvTable table = CsvTable::read(file);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    result.optimization_samples.push_back({table.number(i, "nodes"), table.number(i, "ms")});
    result.optimization_ms += table.number(i, "ms") / static_cast<double>(table.rows());
    result.optimization_cpu_ms += table.number(i, "cpu_ms") / static_cast<double>(table.rows());
  }
  result.optimizations = table.rows();
}

}  // namespace

RunResult evaluate(const RunKey& key, const fs::path& run, const fs::path& dataset,
                   const std::string& name) {
  const Trajectory reference = readTum(dataset / (name + "_gt_robot.tum"));
  const EntityTruths truths = readEntityTruths(dataset / (name + "_gt_entities.csv"));
  const RunReport report = evaluateRun(run, reference, truths.empty() ? nullptr : &truths);
  RunResult result;
  result.key = key;
  result.ate_rmse_m = report.trajectory.ate_m.rmse;
  result.ate_std_m = report.trajectory.ate_m.std;
  if (report.odometry) result.odometry_ate_m = report.odometry->ate_m.rmse;
  if (report.entities) addEntities(report.entities->errors, reference.front().stamp, result);
  addPath(reference, readTum(run / "trajectory.tum"), report.trajectory.T_reference_estimate,
          result);
  addOptimizations(run / "optimizations.csv", result);
  const Json summary = readJson(run / "summary.json");
  if (summary.contains("loops") && summary["loops"].contains("closures"))
    result.loop_closures = summary["loops"]["closures"].get<int>();
  return result;
}

void writeResult(const RunResult& r, const fs::path& file) {
  Json json{{"dataset", r.key.dataset},
            {"seed", r.key.seed},
            {"odometry", r.key.odometry},
            {"setup", r.key.setup},
            {"ate_rmse_m", r.ate_rmse_m},
            {"ate_std_m", r.ate_std_m},
            {"odometry_ate_m", r.odometry_ate_m},
            {"optimization_ms", r.optimization_ms},
            {"optimizations", r.optimizations},
            {"optimization_cpu_ms", r.optimization_cpu_ms},
            {"path", r.path}};
  if (r.loop_closures) json["loop_closures"] = *r.loop_closures;
  json["entities"] = Json::array();
  for (const EntityResult& e : r.entities)
    json["entities"].push_back({e.id, e.semantic_class, e.first_m, e.last_m});
  json["entity_samples"] = Json::array();
  for (const EntitySample& s : r.entity_samples)
    json["entity_samples"].push_back(
        {s.id, s.semantic_class, s.t_s, s.translation_m, s.rotation_deg, s.place});
  json["optimization_samples"] = Json::array();
  for (const OptimizationSample& s : r.optimization_samples)
    json["optimization_samples"].push_back({s.nodes, s.ms});
  writeFileAtomically(file, json.dump() + "\n");
}

RunResult readResult(const fs::path& file) {
  const Json json = readJson(file);
  try {
    RunResult r;
    r.key = {json.at("dataset"), json.at("seed"), json.at("odometry"), json.at("setup")};
    r.ate_rmse_m = json.at("ate_rmse_m");
    r.ate_std_m = json.at("ate_std_m");
    r.odometry_ate_m = json.at("odometry_ate_m");
    r.optimization_ms = json.at("optimization_ms");
    r.optimization_cpu_ms = json.at("optimization_cpu_ms");
    r.optimizations = json.at("optimizations");
    if (json.contains("loop_closures")) r.loop_closures = json["loop_closures"].get<int>();
    for (const auto& e : json.at("entities"))
      r.entities.push_back({e.at(0), e.at(1), e.at(2), e.at(3)});
    for (const auto& s : json.at("entity_samples"))
      r.entity_samples.push_back({s.at(0), s.at(1), s.at(2), s.at(3), s.at(4), s.at(5)});
    for (const auto& s : json.at("optimization_samples"))
      r.optimization_samples.push_back({s.at(0), s.at(1)});
    r.path = json.at("path").get<std::vector<std::array<double, 4>>>();
    return r;
  } catch (const Json::exception& error) {
    throw DataError(file.string() + ": " + error.what());
  }
}

}  // namespace dynemo::experiments
