// The steps of loop closure apart from matching: candidates, prefilter, verification.
#include <benchmark/benchmark.h>

#include "dynemo/loops/candidate_search.h"
#include "dynemo/loops/closure_set.h"
#include "dynemo/loops/entity_prefilter.h"
#include "dynemo/loops/verification.h"
#include "loop_graph.h"

namespace dynemo {
namespace {

constexpr int kLap = 24;

test::LoopGraph drive(int keyframes) {
  test::LoopGraph drive;
  for (int i = 0; i < keyframes; ++i) drive.addKeyframe();
  return drive;
}

void search(benchmark::State& state, CandidateGate gate) {
  test::LoopGraph d = drive(static_cast<int>(state.range(0)));
  OdometryChain chain;
  chain.extend(d.graph);
  CandidateParams params;
  params.gate = gate;
  const CandidateSearch candidates(params, EntityEvidenceParams{});
  for (auto _ : state) {
    benchmark::DoNotOptimize(candidates.search(d.graph, chain, std::nullopt, d.optimizer));
  }
}

void searchByDistance(benchmark::State& state) { search(state, CandidateGate::kDistance); }
BENCHMARK(searchByDistance)->Arg(100)->Arg(1000)->Arg(10000)->Unit(benchmark::kMicrosecond);

void searchByUncertainty(benchmark::State& state) { search(state, CandidateGate::kUncertainty); }
BENCHMARK(searchByUncertainty)->Arg(100)->Arg(1000)->Unit(benchmark::kMicrosecond);

/// Two keyframes that see the same ten objects, of which every other one has moved.
void prefilter(benchmark::State& state, const std::string& method) {
  test::LoopGraph d;
  for (int keyframe = 0; keyframe < 2; ++keyframe) {
    d.addKeyframe();
    for (int i = 0; i < 10; ++i) {
      PointIndices fragment(200);
      for (std::size_t k = 0; k < fragment.size(); ++k)
        fragment[k] = static_cast<std::uint32_t>(200 * i + static_cast<int>(k));
      d.see({i}, Pose3::translation(i, 2 + 0.4 * (keyframe * i % 2), 0), SemanticClass::kObject,
            fragment);
    }
  }
  LoopPair pair;
  pair.candidate = {0, 1, LoopOrigin::kDistance, 0, 0};
  pair.earlier = d.graph.keyframes()[0].get();
  pair.later = d.graph.keyframes()[1].get();
  pair.predicted = {d.trueRelative(0, 1), isotropicCovariance(0.05, 0.02)};
  const PrefilterParams params;
  const auto filter = entityPrefilters().make(method, params);
  for (auto _ : state) {
    pair.shared = sharedEntities(d.graph, *pair.earlier, *pair.later);
    pair.consensus = findConsensus(pair.shared, EntityEvidenceParams{});
    benchmark::DoNotOptimize(filter->filter(d.graph, pair, pair.predicted));
  }
}

void prefilterNone(benchmark::State& state) { prefilter(state, "none"); }
BENCHMARK(prefilterNone)->Unit(benchmark::kMicrosecond);
void prefilterAlways(benchmark::State& state) { prefilter(state, "always"); }
BENCHMARK(prefilterAlways)->Unit(benchmark::kMicrosecond);
void prefilterMotion(benchmark::State& state) { prefilter(state, "motion"); }
BENCHMARK(prefilterMotion)->Unit(benchmark::kMicrosecond);

/// One more closure to a set of so many.
void verification(benchmark::State& state) {
  const auto closures = static_cast<std::size_t>(state.range(0));
  test::LoopGraph d = drive(static_cast<int>(closures) + 2 * kLap);
  OdometryChain chain;
  chain.extend(d.graph);
  const auto closure = [&](std::size_t earlier) {
    return Closure{earlier,
                   earlier + kLap,
                   {d.trueRelative(earlier, earlier + kLap), isotropicCovariance(0.01, 0.002)}};
  };
  ClosureSet set{ConsistencyParams{}};
  for (std::size_t i = 0; i < closures; ++i) set.add(closure(i), chain);
  for (auto _ : state) {
    state.PauseTiming();
    ClosureSet grown = set;
    state.ResumeTiming();
    grown.add(closure(closures), chain);
    benchmark::DoNotOptimize(grown.consistent());
  }
}
BENCHMARK(verification)->Arg(10)->Arg(100)->Arg(1000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dynemo
