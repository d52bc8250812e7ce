// Loop matching on two still scans of 64 × 1024 points of a furnished room, one thread.
#include <benchmark/benchmark.h>

#include "dynemo/matching/matcher_chain.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

struct Pair {
  Scan target, source;
  Pose3 T_target_source;
};

const Pair& pair() {
  static const Pair made = [] {
    test::LidarModel lidar;
    lidar.sweep_s = 0.0;
    std::mt19937_64 random(3);
    const Pose3 T_world_target = Pose3::fromYawPitchRoll(-1.5, -1.0, 0.6, 0.3, 0, 0);
    const Pose3 T_world_source = Pose3::fromYawPitchRoll(-0.3, -1.9, 0.62, 0.8, 0.01, -0.01);
    const auto at = [&](const Pose3& T_world_base) {
      return test::sweep(
          test::furnishedRoom(), lidar, [&](double) { return T_world_base; }, 0.0, random);
    };
    return Pair{at(T_world_target), at(T_world_source), T_world_target.inverse() * T_world_source};
  }();
  return made;
}

/// About 1 m and 15° off.
MatchRequest poorRequest() {
  Vector6 error;
  error << 0.8, -0.6, 0.0, 0.0, 0.0, 0.26;
  return {pair().T_target_source.retract(error), 0.5, 0.15};
}

void prepareScan(benchmark::State& state) {
  const MatchingParams params;
  for (auto _ : state) {
    const MatchScan scan(pair().target, params.scan);
    benchmark::DoNotOptimize(&scan.target());
  }
}
BENCHMARK(prepareScan)->Unit(benchmark::kMillisecond);

void removeFragment(benchmark::State& state) {
  const MatchScan scan(pair().target, MatchingParams().scan);
  PointIndices removed;
  for (std::uint32_t i = 10000; i < 12000; ++i) removed.push_back(i);
  for (auto _ : state) benchmark::DoNotOptimize(scan.without(pair().target, removed).size());
}
BENCHMARK(removeFragment)->Unit(benchmark::kMillisecond);

/// Preparing the newest scan and matching it to one that has been prepared.
void candidate(benchmark::State& state, const std::vector<std::string>& chain) {
  MatchingParams params;
  params.chain = chain;
  const auto matcher = makeScanMatcher(params);
  const MatchScan target(pair().target, params.scan);
  benchmark::DoNotOptimize(&target.target());
  for (auto _ : state) {
    const MatchScan source(pair().source, params.scan);
    benchmark::DoNotOptimize(matcher->match(target, source, poorRequest()));
  }
}
BENCHMARK_CAPTURE(candidate, default_chain, MatchingParams().chain)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(candidate, annealed_gicp, {"annealed_gicp"})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(candidate, mrpt_icp, {"mrpt_icp"})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(candidate, pcl_gicp, {"pcl_gicp"})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(candidate, pcl_ndt, {"pcl_ndt"})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynemo
