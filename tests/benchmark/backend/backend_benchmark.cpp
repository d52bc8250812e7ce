// What an optimisation costs: in batch, at every keyframe of a growing map, and beside Ceres. The
// public pose graphs need the environment variable DYNEMO_POSE_GRAPHS; DYNEMO_BENCHMARK_KEYFRAMES
// sets the sizes of the maps, e.g. 100,500,2000,10000.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <sstream>
#include <string>

#include "ceres_reference.h"
#include "dynemo/backend/chordal_initialization.h"
#include "dynemo/backend/g2o_io.h"
#include "dynemo/backend/optimizer.h"
#include "generated_graph.h"
#include "pose_graph_files.h"

namespace dynemo {
namespace {

std::vector<std::vector<double>> statesOf(const CSceneGraph& graph) {
  std::vector<std::vector<double>> states;
  for (const auto& node : graph.nodeSlots()) {
    states.emplace_back(static_cast<std::size_t>(node->stateSize()));
    node->readState(states.back().data());
  }
  return states;
}

void restore(CSceneGraph& graph, const std::vector<std::vector<double>>& states) {
  for (std::size_t i = 0; i < states.size(); ++i) graph.setState({i}, states[i].data());
}

/// Mean times of the phases.
class Phases {
 public:
  void add(const OptimizationReport& r) {
    if (!r.usable()) failed_ = true;
    ++runs_;
    ordering_ += r.ordering_ms;
    symbolic_ += r.symbolic_ms;
    linearize_ += r.linearize_ms;
    numeric_ += r.numeric_ms;
    solve_ += r.solve_ms;
    factorizations_ += r.factorizations;
    last_ = r;
  }
  void show(benchmark::State& state) const {
    if (failed_) state.SkipWithError("the optimisation failed");
    const auto mean = [this](double sum) { return sum / std::max(runs_, 1); };
    state.counters["order_ms"] = mean(ordering_);
    state.counters["symb_ms"] = mean(symbolic_);
    state.counters["lin_ms"] = mean(linearize_);
    state.counters["num_ms"] = mean(numeric_);
    state.counters["solve_ms"] = mean(solve_);
    state.counters["factorizations"] = mean(factorizations_);
    state.counters["nodes"] = static_cast<double>(last_.nodes);
    state.counters["cost"] = last_.cost_after;
  }

 private:
  bool failed_ = false;
  int runs_ = 0;
  double ordering_ = 0, symbolic_ = 0, linearize_ = 0, numeric_ = 0, solve_ = 0,
         factorizations_ = 0;
  OptimizationReport last_;
};

/// Sizes of the maps: DYNEMO_BENCHMARK_KEYFRAMES, separated by commas.
void mapSizes(benchmark::internal::Benchmark* b) {
  const char* list = std::getenv("DYNEMO_BENCHMARK_KEYFRAMES");
  std::istringstream sizes(list && *list ? list : "60");
  for (std::string size; std::getline(sizes, size, ',');) b->Arg(std::stoi(size));
}

/// A map of that many keyframes from dead reckoning to the minimum.
void BM_Batch(benchmark::State& state) {
  CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  const auto start = statesOf(graph);
  Phases phases;
  for (auto _ : state) {
    state.PauseTiming();
    restore(graph, start);
    Optimizer optimizer({});
    state.ResumeTiming();
    phases.add(optimizer.optimize(graph));
  }
  phases.show(state);
}
BENCHMARK(BM_Batch)->Apply(mapSizes)->Unit(benchmark::kMillisecond);

/// One iteration with everything computed anew.
void BM_BatchOneStep(benchmark::State& state) {
  CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  const auto start = statesOf(graph);
  SolverParams params;
  params.max_iterations = 1;
  Phases phases;
  for (auto _ : state) {
    state.PauseTiming();
    restore(graph, start);
    Optimizer optimizer(params);
    state.ResumeTiming();
    phases.add(optimizer.optimize(graph));
  }
  phases.show(state);
}
BENCHMARK(BM_BatchOneStep)->Apply(mapSizes)->Unit(benchmark::kMillisecond);

/// A map of that many keyframes at its minimum, and the world that continues it.
struct GrownMap {
  explicit GrownMap(int keyframes) : world(test::WorldParams{}) {
    Optimizer optimizer({});
    for (int k = 0; k < keyframes; ++k) {
      graph.apply(world.nextKeyframe(graph));
      if (k < 100 || k % 10 == 9) optimizer.optimize(graph);
    }
  }
  test::GeneratedWorld world;
  CSceneGraph graph;
};

/// Re-optimisation after each new keyframe of a map that has that many already, warm up left out.
void BM_EveryKeyframe(benchmark::State& state, SolverParams::Method method) {
  GrownMap map(static_cast<int>(state.range(0)));
  SolverParams params;
  params.method = method;
  Optimizer optimizer(params);
  const int warm_up = method == SolverParams::Method::kBatch ? 2 : 40;
  for (int k = 0; k < warm_up; ++k) {
    map.graph.apply(map.world.nextKeyframe(map.graph));
    optimizer.optimize(map.graph);
  }
  Phases phases;
  for (auto _ : state) {
    state.PauseTiming();
    map.graph.apply(map.world.nextKeyframe(map.graph));
    state.ResumeTiming();
    phases.add(optimizer.optimize(map.graph));
  }
  phases.show(state);
  // The cost over the minimum.
  const double cost = map.graph.totalCost();
  state.counters["excess"] = cost / optimizer.optimizeFully(map.graph).cost_after - 1.0;
}

/// The same with Ceres, warm started too.
void BM_EveryKeyframeCeres(benchmark::State& state) {
  GrownMap map(static_cast<int>(state.range(0)));
  Optimizer follow({});
  follow.optimize(map.graph);
  test::CeresResult result;
  for (auto _ : state) {
    map.graph.apply(map.world.nextKeyframe(map.graph));
    result = test::solveWithCeres(map.graph, 1e-6);
    state.SetIterationTime(result.seconds);
    follow.optimize(map.graph);
  }
  state.counters["steps"] = result.iterations;
  state.counters["cost"] = result.cost_after;
}

BENCHMARK_CAPTURE(BM_EveryKeyframe, batch, SolverParams::Method::kBatch)
    ->Apply(mapSizes)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(10);
BENCHMARK_CAPTURE(BM_EveryKeyframe, incremental, SolverParams::Method::kIncremental)
    ->Apply(mapSizes)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(100);
BENCHMARK(BM_EveryKeyframeCeres)
    ->Apply(mapSizes)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(5);

void BM_MarginalsOfAllNodes(benchmark::State& state) {
  CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  Optimizer optimizer({});
  optimizer.optimize(graph);
  std::vector<NodeId> nodes;
  for (const auto& node : graph.nodeSlots()) nodes.push_back(node->id);
  for (auto _ : state) {
    if (!optimizer.marginalBlocks(graph, nodes)) state.SkipWithError("no marginals");
  }
}
BENCHMARK(BM_MarginalsOfAllNodes)->Apply(mapSizes)->Unit(benchmark::kMillisecond);

void BM_MarginalsOfOneNode(benchmark::State& state) {
  CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  Optimizer optimizer({});
  optimizer.optimize(graph);
  const std::vector<NodeId> nodes = {graph.keyframes().back()->id};
  for (auto _ : state) {
    if (!optimizer.marginalCovariance(graph, nodes)) state.SkipWithError("no marginals");
  }
}
BENCHMARK(BM_MarginalsOfOneNode)->Apply(mapSizes)->Unit(benchmark::kMillisecond);

std::optional<CSceneGraph> publicGraph(benchmark::State& state, const std::string& name) {
  const auto file = test::largePoseGraph(name);
  if (!file) {
    state.SkipWithError("DYNEMO_POSE_GRAPHS does not name a folder with it");
    return std::nullopt;
  }
  CSceneGraph graph = readG2o(*file).graph;
  if (name == "torus3D.g2o" && !initializeChordal(graph))
    state.SkipWithError("no chordal initialisation");
  return graph;
}

void BM_PublicGraph(benchmark::State& state, const std::string& name) {
  auto graph = publicGraph(state, name);
  if (!graph) return;
  const auto start = statesOf(*graph);
  Phases phases;
  for (auto _ : state) {
    state.PauseTiming();
    restore(*graph, start);
    Optimizer optimizer({});
    state.ResumeTiming();
    phases.add(optimizer.optimize(*graph));
  }
  phases.show(state);
}

void BM_PublicGraphCeres(benchmark::State& state, const std::string& name) {
  const auto graph = publicGraph(state, name);
  if (!graph) return;
  test::CeresResult result;
  for (auto _ : state) {
    // Its own clock leaves out building the problem.
    result = test::solveWithCeres(*graph, 1e-6);
    state.SetIterationTime(result.seconds);
  }
  state.counters["cost"] = result.cost_after;
  state.counters["steps"] = result.iterations;
}

BENCHMARK_CAPTURE(BM_PublicGraph, sphere2500, "sphere2500.g2o")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_PublicGraphCeres, sphere2500, "sphere2500.g2o")
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK_CAPTURE(BM_PublicGraph, parking_garage, "parking-garage.g2o")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_PublicGraphCeres, parking_garage, "parking-garage.g2o")
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK_CAPTURE(BM_PublicGraph, torus3D, "torus3D.g2o")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynemo
