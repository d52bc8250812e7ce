#include "dynemo/pipeline/run_folder.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"
#include "dynemo/exporters/exporter.h"
#include "dynemo/graph/session.h"

namespace dynemo {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

std::string milliseconds(double ms) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.3f", ms);
  return buffer;
}

fs::path createFolder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure || !fs::is_directory(folder)) {
    throw DataError("output folder " + folder.string() + ": cannot be created" +
                    (failure ? ": " + failure.message() : ": a file of that name is in the way"));
  }
  return folder;
}

/// The session is a folder of its own, not the file of an exporter.
constexpr const char* kSession = "session";

Session sessionOf(const RunResult& run, const std::string& config_yaml) {
  return {run.graph,
          config_yaml,
          run.frames,
          run.entity_covariances,
          run.plane_covariances ? *run.plane_covariances : std::map<NodeId, Matrix3>{},
          {run.keyframes_without_closures.begin(), run.keyframes_without_closures.end()}};
}

std::vector<std::string> knownOutputs(const std::vector<std::string>& names) {
  std::vector<std::string> known = exporters().names();
  known.emplace_back(kSession);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string list;
    for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
    throw ConfigError("outputs: " + name + ": must be among: " + list);
  }
  return names;
}

Json poseJson(const Pose3& T) {
  const auto q = T.quaternion();
  return {{"position_m", {T.t.x(), T.t.y(), T.t.z()}},
          {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

Json entitiesJson(const CSceneGraph& graph) {
  Json list = Json::array();
  for (const auto& [id, track] : graph.tracks()) {
    const auto moves =
        std::count_if(track.begin(), track.end(), [](const auto& node) { return node->moved; });
    list.push_back({{"id", id.value},
                    {"name", track.front()->name},
                    {"class", semanticClassName(track.front()->semantic_class)},
                    {"observations", track.size()},
                    {"moved", moves > 0},
                    {"moves", moves},
                    {"last_seen", track.back()->stamp.text()},
                    {"T_map_entity", poseJson(track.back()->T_map_entity())}});
  }
  return list;
}

Json graphJson(const CSceneGraph& graph) {
  std::map<std::string, std::size_t> nodes, edges;
  for (const auto& node : graph.nodeSlots()) {
    if (node) ++nodes[node->kind()];
  }
  for (const auto& edge : graph.edgeSlots()) {
    if (edge) ++edges[edge->kind()];
  }
  return {{"nodes", nodes}, {"edges", edges}, {"cost", graph.totalCost()}};
}

}  // namespace

RunFolder::RunFolder(const fs::path& folder, const DynemoParams& params)
    : outputs_(knownOutputs(params.outputs)),
      exports_(params.exports),
      folder_(createFolder(folder)),
      config_yaml_(toYaml(params)),
      log_(folder / "log.txt"),
      timing_(folder / "timing.csv"),
      optimizations_(folder / "optimizations.csv"),
      loops_(folder / "loops.csv") {
  writeFileAtomically(folder_ / "config.yaml", config_yaml_);
  std::string header = "frame,timestamp";
  for (const char* stage : kStageNames) header += std::string(",") + stage + "_ms";
  timing_.line(header + ",total_ms");
  optimizations_.line(
      "frame,timestamp,nodes,edges,iterations,factorizations,cost_before,cost_after,stop,ordering_"
      "ms,symbolic_ms,"
      "linearize_ms,numeric_ms,solve_ms,cpu_ms,ms");
  loops_.line(loopRecordHeader());
}

void RunFolder::frame(std::uint64_t index, Stamp stamp, const FrameTiming& timing) {
  std::string line = std::to_string(index) + "," + stamp.text();
  for (const double ms : timing.ms) line += "," + milliseconds(ms);
  timing_.line(line + "," + milliseconds(timing.total()));
  timings_.push_back(timing);
}

void RunFolder::optimizations(const std::vector<OptimizationRecord>& all) {
  for (; optimizations_written_ < all.size(); ++optimizations_written_) {
    const auto& [frame, stamp, r] = all[optimizations_written_];
    optimization_ms_ += r.total_ms;
    optimization_cpu_ms_ += r.cpu_ms;
    std::string line = std::to_string(frame) + "," + stamp.text() + "," + std::to_string(r.nodes) +
                       "," + std::to_string(r.edges) + "," + std::to_string(r.iterations) + "," +
                       std::to_string(r.factorizations) + "," + exactNumber(r.cost_before) + "," +
                       exactNumber(r.cost_after) + "," + stopReasonName(r.stop);
    for (const double ms : {r.ordering_ms, r.symbolic_ms, r.linearize_ms, r.numeric_ms, r.solve_ms,
                            r.cpu_ms, r.total_ms}) {
      line += "," + milliseconds(ms);
    }
    optimizations_.line(line);
  }
}

void RunFolder::loops(const std::vector<LoopRecord>& all) {
  for (; loops_written_ < all.size(); ++loops_written_)
    loops_.line(loopRecordRow(all[loops_written_]));
}

namespace {

Json loopsJson(const SlamPipeline& pipeline) {
  std::map<std::string, std::size_t> decisions = {{"accepted", 0}, {"rejected", 0}, {"removed", 0}};
  for (const LoopRecord& loop : pipeline.loops()) ++decisions[loopDecisionName(loop.decision)];
  return {{"closures", decisions["accepted"] - decisions["removed"]}, {"decisions", decisions}};
}

Json keyframesJson(const SlamPipeline& pipeline) {
  const auto& keyframes = pipeline.graph().keyframes();
  std::map<std::string, std::size_t> reasons;
  for (const auto& keyframe : keyframes) ++reasons[keyframeReasonText(keyframe->reasons)];
  Json json = {{"count", keyframes.size()}, {"reasons", reasons}};
  if (pipeline.keyframesLeft() > 0) json["left_the_graph"] = pipeline.keyframesLeft();
  return json;
}

Json summaryJson(const SlamPipeline& pipeline, const IngestReport& ingest,
                 const RunIdentity& identity) {
  const CSceneGraph& graph = pipeline.graph();
  Json summary = {{"program", "dynemo-slam"},
                  {"version", identity.version},
                  {"setup", identity.setup},
                  {"rawlog", identity.rawlog},
                  {"frames", ingest.frames},
                  {"observations", ingest.observations},
                  {"keyframes", keyframesJson(pipeline)},
                  {"graph", graphJson(graph)},
                  {"entities", entitiesJson(graph)},
                  {"loops", loopsJson(pipeline)},
                  {"T_map_odom", poseJson(graph.T_map_odom)},
                  {"floors", Json::array()}};
  if (const auto& cov = pipeline.driftCovariance()) {
    const Vector6 sigmas = cov->diagonal().cwiseSqrt();
    summary["T_map_odom"]["sigma"] = std::vector<double>(sigmas.data(), sigmas.data() + 6);
  }
  for (const auto& floor : graph.floors())
    summary["floors"].push_back({{"level_m", floor->level_m}});
  auto warnings = ingest.warnings;
  for (const auto& [text, count] : pipeline.warnings()) warnings[text] += count;
  summary["warnings"] = warnings;
  summary["doubts"] = pipeline.doubts();
  return summary;
}

}  // namespace

void RunFolder::results(const SlamPipeline& pipeline, const IngestReport& ingest,
                        const RunIdentity& identity) {
  write(outputs_, pipeline, ingest, identity);
}

void RunFolder::checkpoint(SlamPipeline& pipeline, const IngestReport& ingest,
                           const RunIdentity& identity) {
  pipeline.updateTrajectory();
  std::vector<std::string> light;
  for (const std::string& name : outputs_) {
    if (name == "trajectory" || name == "keyframes" || name == "odometry" || name == "entities")
      light.push_back(name);
  }
  write(light, pipeline, ingest, identity);
}

void RunFolder::write(const std::vector<std::string>& outputs, const SlamPipeline& pipeline,
                      const IngestReport& ingest, const RunIdentity& identity) {
  std::string failures;
  const auto attempt = [&](const std::function<void()>& action) {
    try {
      action();
    } catch (const std::exception& e) {
      failures += (failures.empty() ? "" : "; ") + std::string(e.what());
    }
  };
  const RunResult run = pipeline.result();
  for (const std::string& name : outputs) {
    attempt([&] {
      if (name == kSession) return saveSession(sessionOf(run, config_yaml_), folder_ / kSession);
      const auto exporter = exporters().make(name, exports_);
      exporter->write(run, folder_ / exporter->fileName());
    });
  }
  attempt([&] {
    writeFileAtomically(folder_ / "summary.json",
                        summaryJson(pipeline, ingest, identity).dump(2) + "\n");
  });
  if (!failures.empty()) throw DataError(failures);
}

void RunFolder::performance(const RunCost& cost) {
  Json stages;
  for (std::size_t s = 0; s < kStageNames.size(); ++s) {
    std::vector<double> ms;
    for (const FrameTiming& t : timings_) ms.push_back(t.ms[s]);
    if (ms.empty()) continue;
    std::sort(ms.begin(), ms.end());
    double sum = 0;
    for (const double t : ms) sum += t;
    stages[kStageNames[s]] = {
        {"mean_ms", sum / static_cast<double>(ms.size())},
        {"p95_ms",
         ms[(ms.size() * 95) / 100 == ms.size() ? ms.size() - 1 : (ms.size() * 95) / 100]},
        {"max_ms", ms.back()}};
  }
  const Json json = {{"frames", timings_.size()},
                     {"dataset_s", cost.dataset_s},
                     {"wall_s", cost.wall_s},
                     {"cpu_s", cost.cpu_s},
                     {"real_time_factor", cost.wall_s > 0 ? cost.dataset_s / cost.wall_s : 0.0},
                     {"peak_rss_mb", cost.peak_rss_mb},
                     {"optimizations", optimizations_written_},
                     {"optimization_ms", optimization_ms_},
                     {"optimization_cpu_ms", optimization_cpu_ms_},
                     {"stages", stages}};
  writeFileAtomically(folder_ / "performance.json", json.dump(2) + "\n");
}

}  // namespace dynemo
