// What an optimisation of a map costs, in batch and at every keyframe while the map grows, beside
// Ceres and MRPT. Times are those of the processor for the thread that answers.
//
// DYNEMO_BENCHMARK_KEYFRAMES sets the sizes of the maps, e.g. 100,500,2000,10000;
// share/scripts/plot-performance.py makes share/doc/performance.md of the results.
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>

#include "benchmark_support.h"
#include "ceres_reference.h"
#include "generated_graph.h"
#include "mrpt_reference.h"

namespace dynemo {
namespace {

/// While a map is made ready.
constexpr int kBetweenOptimizations = 250;
/// Longer ones keep the second thread busy for too long.
constexpr int kLongestWindowedLife = 2000;

/// A building of eight storeys with loops on each, which the robot visits over and over.
test::WorldParams building() {
  test::WorldParams params;
  params.storeys = 8;
  return params;
}

std::vector<int> mapSizes() {
  const char* list = std::getenv("DYNEMO_BENCHMARK_KEYFRAMES");
  std::istringstream text(list && *list ? list : "60");
  std::vector<int> sizes;
  for (std::string size; std::getline(text, size, ',');) sizes.push_back(std::stoi(size));
  return sizes;
}

void showExcess(benchmark::State& state, CSceneGraph& graph) {
  const double cost = graph.totalCost();
  Optimizer reference({});
  state.counters["excess"] = cost / reference.optimizeFully(graph).cost_after - 1.0;
}

/// From dead reckoning.
void BM_Batch(benchmark::State& state, int max_iterations) {
  CSceneGraph graph = test::generateGraph(building(), static_cast<int>(state.range(0)));
  const States start = statesOf(graph);
  SolverParams params;
  params.max_iterations = max_iterations;
  Phases phases;
  for (auto _ : state) {
    restore(graph, start);
    Optimizer optimizer(params);
    state.SetIterationTime(secondsOf([&] { phases.add(optimizer.optimizeFully(graph)); }));
  }
  phases.show(state);
}

/// A map of a size, at its minimum.
class GrownMap {
 public:
  explicit GrownMap(int keyframes) : world_(building()) {
    for (int k = 0; k < keyframes; ++k) grow();
    restore(graph_, estimates(keyframes));
  }
  CSceneGraph& graph() { return graph_; }
  void grow() { graph_.apply(world_.nextKeyframe(graph_)); }

 private:
  /// Remembered, since every method begins there.
  static const States& estimates(int keyframes) {
    static std::map<int, States> known;
    const auto [it, unknown] = known.try_emplace(keyframes);
    if (unknown) {
      test::GeneratedWorld world(building());
      CSceneGraph graph;
      Optimizer optimizer({});
      for (int k = 1; k <= keyframes; ++k) {
        graph.apply(world.nextKeyframe(graph));
        if (k % kBetweenOptimizations == 0 || k == keyframes) optimizer.optimizeFully(graph);
      }
      it->second = statesOf(graph);
    }
    return it->second;
  }

  test::GeneratedWorld world_;
  CSceneGraph graph_;
};

/// After each of the keyframes that follow; the first ones, in which the method finds its feet, are
/// not counted.
void BM_Keyframe(benchmark::State& state, const SolverParams& params, int warm_up) {
  GrownMap map(static_cast<int>(state.range(0)));
  Optimizer optimizer(params);
  for (int k = 0; k < warm_up; ++k) {
    map.grow();
    optimizer.optimize(map.graph());
  }
  Phases phases;
  double longest = 0.0;
  for (auto _ : state) {
    map.grow();
    OptimizationReport report;
    const double seconds = secondsOf([&] { report = optimizer.optimize(map.graph()); });
    state.SetIterationTime(seconds);
    phases.add(report);
    longest = std::max(longest, seconds);
  }
  phases.show(state);
  state.counters["longest_ms"] = 1e3 * longest;
  showExcess(state, map.graph());
}

template <class Solve>
void keyframeByOther(benchmark::State& state, Solve solve) {
  GrownMap map(static_cast<int>(state.range(0)));
  Optimizer follow({});
  for (auto _ : state) {
    map.grow();
    solve(map.graph());
    follow.optimize(map.graph());
  }
}

void BM_KeyframeCeres(benchmark::State& state) {
  keyframeByOther(state, [&](const CSceneGraph& graph) {
    const test::CeresResult result = test::solveWithCeres(graph, 1e-6);
    state.SetIterationTime(result.seconds);
    state.counters["steps"] = result.iterations;
    state.counters["cost"] = result.cost_after;
  });
}

void BM_KeyframeMrpt(benchmark::State& state) {
  keyframeByOther(state, [&](const CSceneGraph& graph) {
    const test::MrptResult result = test::solveWithMrpt(graph, 1e-6);
    state.SetIterationTime(result.seconds);
    state.counters["steps"] = result.iterations;
    state.counters["edges_share"] = result.edges_share;
  });
}

/// The whole life of a map: the mean over all its keyframes.
void BM_Life(benchmark::State& state, SolverParams::Method method) {
  const int keyframes = static_cast<int>(state.range(0));
  for (auto _ : state) {
    test::GeneratedWorld world(building());
    CSceneGraph graph;
    SolverParams params;
    params.method = method;
    Optimizer optimizer(params);
    double seconds = 0.0;
    for (int k = 0; k < keyframes; ++k) {
      graph.apply(world.nextKeyframe(graph));
      seconds += secondsOf([&] { optimizer.optimize(graph); });
    }
    state.SetIterationTime(seconds / keyframes);
    showExcess(state, graph);
  }
}

void BM_Marginals(benchmark::State& state, bool all_nodes) {
  CSceneGraph graph = test::generateGraph(building(), static_cast<int>(state.range(0)));
  Optimizer optimizer({});
  optimizer.optimize(graph);
  std::vector<NodeId> nodes = {graph.keyframes().back()->id};
  if (all_nodes) {
    for (const auto& node : graph.nodeSlots()) nodes.push_back(node->id);
  }
  const auto known = [&] {
    return all_nodes ? optimizer.marginalBlocks(graph, nodes).has_value()
                     : optimizer.marginalCovariance(graph, nodes).has_value();
  };
  // The first one after a batch solution makes the factorisation.
  if (!known()) state.SkipWithError("no marginals");
  for (auto _ : state) state.SetIterationTime(secondsOf(known));
}

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, int size, auto run, int iterations = 0) {
    auto* b = benchmark::RegisterBenchmark(("Map/" + name).c_str(), run);
    b->Arg(size)->Unit(benchmark::kMillisecond)->UseManualTime();
    if (iterations > 0) b->Iterations(iterations);
  };
  using Method = SolverParams::Method;
  for (const int size : mapSizes()) {
    add("one_step", size, [](benchmark::State& s) { BM_Batch(s, 1); });
    add("to_convergence", size,
        [](benchmark::State& s) { BM_Batch(s, SolverParams{}.max_iterations); });
    const auto keyframe = [&](const std::string& name, const SolverParams& params, int warm_up,
                              int count) {
      add(
          "keyframe/" + name, size, [=](benchmark::State& s) { BM_Keyframe(s, params, warm_up); },
          count);
    };
    keyframe("batch", {.method = Method::kBatch}, 2, 10);
    keyframe("batch_step", {.method = Method::kBatch, .max_iterations = 1}, 2, 10);
    // Over so many that renewals of the elimination order and merges have their share.
    const int warm_up = std::min(50, size / 4), count = std::min(100, size / 2);
    keyframe("incremental", {.method = Method::kIncremental}, warm_up, count);
    keyframe("windowed", {.method = Method::kWindowed}, warm_up, count);
    // Samples: at the largest sizes a keyframe takes them seconds.
    add("keyframe/ceres", size, BM_KeyframeCeres, 3);
    add("keyframe/mrpt", size, BM_KeyframeMrpt, 2);
    for (const auto& [name, method] :
         {std::pair<std::string, Method>{"incremental", Method::kIncremental},
          {"windowed", Method::kWindowed}}) {
      if (method == Method::kWindowed && size > kLongestWindowedLife) break;
      add(
          "life/" + name, size, [m = method](benchmark::State& s) { BM_Life(s, m); }, 1);
    }
    add("marginals_of_one", size, [](benchmark::State& s) { BM_Marginals(s, false); });
    add("marginals_of_all", size, [](benchmark::State& s) { BM_Marginals(s, true); });
  }
  return true;
}();

}  // namespace
}  // namespace dynemo
