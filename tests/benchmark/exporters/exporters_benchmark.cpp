// Time of each exporter on a run of the given number of keyframes, ten frames and one entity each.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <random>

#include "dynemo/exporters/exporter.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

constexpr int kFramesPerKeyframe = 10;
constexpr int kPointsPerScan = 16384;

struct Run {
  CSceneGraph graph;
  std::vector<FramePose> frames;
  std::map<NodeId, Matrix6> covariances;
};

/// A cylindrical room of 8 m around the sensor.
std::shared_ptr<const Scan> roomScan() {
  auto scan = std::make_shared<Scan>();
  for (int i = 0; i < kPointsPerScan; ++i) {
    const float angle =
        6.2831853f * static_cast<float>(i) / static_cast<float>(kPointsPerScan / 16);
    const float height = 0.1f * static_cast<float>(i / (kPointsPerScan / 16)) - 0.5f;
    scan->cloud.points.emplace_back(8.0f * std::cos(angle), 8.0f * std::sin(angle), height);
  }
  return scan;
}

Pose3 poseAlongCircle(double s) {
  return Pose3::fromYawPitchRoll(5.0 * std::cos(s), 5.0 * std::sin(s), 0.0, s, 0.0, 0.0);
}

void addKeyframe(Run& run, int index, const std::shared_ptr<const Scan>& scan) {
  const NodeId keyframe_id = run.graph.nextNodeId();
  auto keyframe = std::make_shared<CNodeKeyframe>();
  keyframe->id = keyframe_id;
  keyframe->stamp = {1'000'000'000LL * index};
  keyframe->T_map_node = keyframe->T_odom_base = poseAlongCircle(0.1 * index);
  keyframe->scan = scan;
  auto entity = std::make_shared<CNodeEntity>();
  entity->id = {keyframe_id.value + 1};
  entity->entity = {index % 10};
  entity->keyframe = keyframe_id;
  entity->stamp = keyframe->stamp;
  entity->T_map_node = keyframe->T_map_node * Pose3::translation(2.0, 0.0, 0.0);
  std::mt19937_64 rng(1);
  auto seen = CEdgeKeyframeEntity::example(rng);
  seen->nodes = {keyframe_id, entity->id};
  seen->id = run.graph.nextEdgeId();
  GraphDelta delta{{keyframe, entity}, {seen}, {}};
  if (index > 0) {
    auto odometry = CEdgeOdometry::example(rng);
    odometry->nodes = {run.graph.keyframes().back()->id, keyframe_id};
    odometry->id = {seen->id.value + 1};
    delta.edges.push_back(odometry);
  }
  run.graph.apply(delta);
  run.covariances[entity->id] = Matrix6::Identity();
}

Run exampleRun(int keyframes) {
  Run run;
  const auto scan = roomScan();
  for (int i = 0; i < keyframes; ++i) addKeyframe(run, i, scan);
  for (int i = 0; i < keyframes * kFramesPerKeyframe; ++i) {
    const Pose3 T = poseAlongCircle(0.1 * i / kFramesPerKeyframe);
    run.frames.push_back({{100'000'000LL * i}, T, T});
  }
  return run;
}

/// Of a file, or of all files in a folder.
std::uintmax_t sizeOf(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return std::filesystem::file_size(path);
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path)) bytes += entry.file_size();
  return bytes;
}

/// Made once for every size, with whose the points of its scans are: the exporters of a run share
/// what they find out.
const RunResult& exampleResult(int keyframes) {
  static std::map<int, Run> runs;
  static std::map<int, RunResult> results;
  if (const auto known = results.find(keyframes); known != results.end()) return known->second;
  const Run& run = runs.emplace(keyframes, exampleRun(keyframes)).first->second;
  const RunResult result{run.graph, run.frames, run.covariances};
  pointOwners(result, {}, {});
  return results.emplace(keyframes, result).first->second;
}

void benchmarkExporter(benchmark::State& state, const std::string& name) {
  const RunResult& result = exampleResult(static_cast<int>(state.range(0)));
  const auto exporter = exporters().make(name, ExportParams());
  const auto file = std::filesystem::temp_directory_path() /
                    ("dynemo-benchmark-" + std::to_string(::getpid()) + exporter->fileName());
  for (auto _ : state) exporter->write(result, file);
  state.counters["bytes"] = static_cast<double>(sizeOf(file));
  std::filesystem::remove_all(file);
}

void benchmarkPointOwners(benchmark::State& state) {
  const RunResult& result = exampleResult(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(PointOwners(result.graph, result.entity_covariances));
}
BENCHMARK(benchmarkPointOwners)
    ->Name("point_owners")
    ->Arg(10)
    ->Arg(100)
    ->Unit(benchmark::kMillisecond);

/// One benchmark per registered exporter, found by the registry.
const bool kRegistered = [] {
  for (const std::string& name : exporters().names()) {
    benchmark::RegisterBenchmark(("export/" + name).c_str(), benchmarkExporter, name)
        ->Arg(10)
        ->Arg(100)
        ->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace dynemo
