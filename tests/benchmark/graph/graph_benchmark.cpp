#include <benchmark/benchmark.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include "dynemo/graph/types.h"
#include "generated_graph.h"

namespace dynemo {
namespace {

/// Residual and Jacobians of one edge of each kind.
void BM_EvaluateEdge(benchmark::State& state) {
  const EdgeType& type = edgeTypes()[static_cast<std::size_t>(state.range(0))];
  std::mt19937_64 rng(1);
  const auto edge = type.example(rng);
  std::vector<std::vector<double>> states;
  for (const std::string& kind : type.node_kinds) {
    for (const NodeType& node_type : nodeTypes()) {
      if (node_type.kind != kind) continue;
      states.emplace_back(16);
      node_type.example(rng)->readState(states.back().data());
    }
  }
  std::vector<const double*> pointers;
  for (const auto& s : states) pointers.push_back(s.data());
  Residual e;
  Jacobians J;
  for (auto _ : state) {
    edge->evaluate(pointers, e, &J);
    benchmark::DoNotOptimize(e.data());
    benchmark::DoNotOptimize(J.data());
  }
  state.SetLabel(type.kind);
}
BENCHMARK(BM_EvaluateEdge)->DenseRange(0, static_cast<std::int64_t>(edgeTypes().size()) - 1);

void BM_TotalCost(benchmark::State& state) {
  const CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(graph.totalCost());
  state.counters["edges"] = static_cast<double>(graph.edgeCount());
}
BENCHMARK(BM_TotalCost)->Arg(100)->Arg(500)->Unit(benchmark::kMicrosecond);

void BM_ApplyKeyframe(benchmark::State& state) {
  test::GeneratedWorld world({});
  CSceneGraph graph;
  for (auto _ : state) {
    state.PauseTiming();
    const GraphDelta delta = world.nextKeyframe(graph);
    state.ResumeTiming();
    graph.apply(delta);
  }
}
BENCHMARK(BM_ApplyKeyframe)->Unit(benchmark::kMicrosecond)->Iterations(500);

void BM_Save(benchmark::State& state) {
  const CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  std::int64_t bytes = 0;
  for (auto _ : state) {
    mrpt::io::CMemoryStream stream;
    auto archive = mrpt::serialization::archiveFrom(stream);
    archive << graph;
    bytes += static_cast<std::int64_t>(stream.getTotalBytesCount());
  }
  state.SetBytesProcessed(bytes);
}
BENCHMARK(BM_Save)->Arg(100)->Arg(500)->Unit(benchmark::kMillisecond);

void BM_Load(benchmark::State& state) {
  registerGraphClasses();
  const CSceneGraph graph = test::generateGraph({}, static_cast<int>(state.range(0)));
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << graph;
  for (auto _ : state) {
    stream.Seek(0);
    CSceneGraph copy;
    archive >> copy;
    benchmark::DoNotOptimize(copy.nodeCount());
  }
}
BENCHMARK(BM_Load)->Arg(100)->Arg(500)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynemo
