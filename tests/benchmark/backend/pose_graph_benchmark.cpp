// The public pose graphs, beside Ceres and MRPT. They need the environment variable
// DYNEMO_POSE_GRAPHS.
#include <optional>
#include <string>

#include "benchmark_support.h"
#include "ceres_reference.h"
#include "dynemo/backend/chordal_initialization.h"
#include "dynemo/backend/g2o_io.h"
#include "mrpt_reference.h"
#include "pose_graph_files.h"

namespace dynemo {
namespace {

enum class Start { kFile, kChordal };

std::optional<CSceneGraph> publicGraph(benchmark::State& state, const std::string& name,
                                       Start start) {
  const auto file = test::largePoseGraph(name);
  if (!file) {
    state.SkipWithError("DYNEMO_POSE_GRAPHS does not name a folder with it");
    return std::nullopt;
  }
  CSceneGraph graph = readG2o(*file).graph;
  if (start == Start::kChordal && !initializeChordal(graph))
    state.SkipWithError("no chordal initialisation");
  return graph;
}

void BM_PoseGraph(benchmark::State& state, const std::string& name, Start from) {
  auto graph = publicGraph(state, name, from);
  if (!graph) return;
  const auto start = statesOf(*graph);
  Phases phases;
  for (auto _ : state) {
    restore(*graph, start);
    Optimizer optimizer({});
    state.SetIterationTime(secondsOf([&] { phases.add(optimizer.optimizeFully(*graph)); }));
  }
  phases.show(state);
}

/// From the file's own guess, whatever it is worth: as `dynemo-optimize --initial chordal` does.
void BM_PoseGraphChordal(benchmark::State& state, const std::string& name) {
  auto graph = publicGraph(state, name, Start::kFile);
  if (!graph) return;
  const auto start = statesOf(*graph);
  Phases phases;
  for (auto _ : state) {
    restore(*graph, start);
    Optimizer optimizer({});
    state.SetIterationTime(secondsOf([&] {
      if (!initializeChordal(*graph)) state.SkipWithError("no chordal initialisation");
      phases.add(optimizer.optimizeFully(*graph));
    }));
  }
  phases.show(state);
}

/// By their own clocks, which leave out building the problem.
template <class Solve>
auto solveByPeer(benchmark::State& state, const std::string& name, Start start, Solve solve)
    -> std::invoke_result_t<Solve, const CSceneGraph&, double> {
  const auto graph = publicGraph(state, name, start);
  if (!graph) return {};
  std::invoke_result_t<Solve, const CSceneGraph&, double> result;
  for (auto _ : state) {
    result = solve(*graph, 1e-6);
    state.SetIterationTime(result.seconds);
  }
  state.counters["steps"] = result.iterations;
  return result;
}

void BM_PoseGraphCeres(benchmark::State& state, const std::string& name, Start start) {
  state.counters["cost"] = solveByPeer(state, name, start, [](const auto&... all) {
                             return test::solveWithCeres(all...);
                           }).cost_after;
}

void BM_PoseGraphMrpt(benchmark::State& state, const std::string& name, Start start) {
  solveByPeer(state, name, start, [](const auto&... all) { return test::solveWithMrpt(all...); });
}

using Method = void (*)(benchmark::State&, const std::string&, Start);

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, auto run) {
    benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond)->UseManualTime();
  };
  struct Graph {
    std::string name;
    Start start;
  };
  for (const auto& [name, start] :
       {Graph{"smallGrid3D", Start::kFile}, Graph{"parking-garage", Start::kFile},
        Graph{"sphere2500", Start::kFile}, Graph{"torus3D", Start::kChordal}}) {
    const std::string file = name + ".g2o";
    for (const auto& [method, run] : {std::pair<std::string, Method>{"batch", BM_PoseGraph},
                                      {"ceres", BM_PoseGraphCeres},
                                      {"mrpt", BM_PoseGraphMrpt}}) {
      add("PoseGraph/" + name + "/" + method,
          [=](benchmark::State& state) { run(state, file, start); });
    }
  }
  for (const std::string name : {"sphere2500", "torus3D"}) {
    add("PoseGraph/" + name + "/file_guess",
        [=](benchmark::State& state) { BM_PoseGraphChordal(state, name + ".g2o"); });
  }
  return true;
}();

}  // namespace
}  // namespace dynemo
