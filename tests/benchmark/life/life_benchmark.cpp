// A robot that goes over one floor again and again, with and without a bounded life: time per
// keyframe, memory, and the error of its whole trajectory. DYNEMO_LIFE_KEYFRAMES sets how long it
// goes on, DYNEMO_LIFE_SEEDS in how many worlds; "early" is around the tenth part of that, "late"
// at its end. Without the bounded life only every tenth keyframe is optimised, which is enough for
// the error. Lines on the standard error tell how it goes on the way; memory is the process's,
// which a run of more than one benchmark leaves holes in.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>

#include "dynemo/backend/optimizer.h"
#include "dynemo/evaluation/alignment.h"
#include "dynemo/life/keyframe_retention.h"
#include "dynemo/life/keyframe_trail.h"
#include "dynemo/life/removal.h"
#include "dynemo/life/settling.h"
#include "generated_truth.h"

namespace dynemo {
namespace {

int fromEnvironment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text && *text ? std::atoi(text) : otherwise;
}
int keyframes() { return fromEnvironment("DYNEMO_LIFE_KEYFRAMES", 300); }
int seeds() { return fromEnvironment("DYNEMO_LIFE_SEEDS", 1); }

constexpr int kBetweenLines = 1000;

test::WorldParams oneFloor(std::int64_t seed) {
  test::WorldParams params;
  params.seed = static_cast<std::uint64_t>(seed);
  params.storeys = 1;
  return params;
}

double cpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double residentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  statm >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// A run over the floor.
class Run {
 public:
  Run(const LifeParams& life, const test::WorldParams& floor)
      : life_(life), floor_(floor), world_(floor), optimizer_(SolverParams()) {}

  void keyframe() {
    graph_.apply(world_.nextKeyframe(graph_));
    trail_.add(*graph_.keyframes().back());
    const double start = cpuSeconds();
    if (life_.bounded) shrink();
    const double shrunk = cpuSeconds();
    if (life_.bounded || (removal_s_.size() + 1) % 10 == 0) optimizer_.optimize(graph_);
    removal_s_.push_back(shrunk - start);
    seconds_.push_back(cpuSeconds() - start);
    resident_mb_.push_back(residentMegabytes());
  }

  void finish() { optimizer_.optimizeFully(graph_); }

  /// Mean of the keyframes [begin, end) [ms].
  double mean_ms(int begin, int end) const { return 1e3 * mean(seconds_, begin, end); }
  double meanRemoval_ms(int begin, int end) const { return 1e3 * mean(removal_s_, begin, end); }
  /// The same of what the process takes, and the most.
  double mean_MB(int begin, int end) const { return mean(resident_mb_, begin, end); }
  double peak_MB(int begin, int end) const {
    return *std::max_element(resident_mb_.begin() + begin, resident_mb_.begin() + end);
  }

  /// Of all keyframes ever, aligned.
  double ate_m() const {
    std::vector<Vector3> truth, estimate;
    for (std::size_t k = 0; k < trail_.size(); ++k) {
      truth.push_back(test::trueRobotPose(floor_, static_cast<int>(k)).t);
      estimate.push_back(trail_.T_map_base(k, graph_).t);
    }
    const auto T = alignPoints(truth, estimate);
    if (!T) return std::nan("");
    double sum = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k)
      sum += (truth[k] - *T * estimate[k]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }
  const CSceneGraph& graph() const { return graph_; }

 private:
  static double mean(const std::vector<double>& all, int begin, int end) {
    double sum = 0.0;
    for (int k = begin; k < end; ++k) sum += all[static_cast<std::size_t>(k)];
    return sum / std::max(1, end - begin);
  }

  void shrink() {
    const std::vector<NodeId> surplus = surplusKeyframes(graph_, life_);
    if (surplus.empty()) return;
    trail_.hang(surplus, graph_);
    graph_.apply(settledTies(graph_, life_));
    for (const NodeId keyframe : surplus) graph_.apply(removalOf(graph_, keyframe, life_));
  }

  LifeParams life_;
  test::WorldParams floor_;
  test::GeneratedWorld world_;
  CSceneGraph graph_;
  Optimizer optimizer_;
  KeyframeTrail trail_;
  std::vector<double> seconds_, removal_s_, resident_mb_;
};

void tellProgress(const Run& run, int k) {
  if ((k + 1) % kBetweenLines != 0) return;
  const int begin = k + 1 - kBetweenLines, end = k + 1;
  std::fprintf(stderr,
               "%6d: %.2f ms (removal %.2f) a keyframe, %.1f MB (peak %.1f), %zu keyframes, "
               "ATE %.2f mm\n",
               end, run.mean_ms(begin, end), run.meanRemoval_ms(begin, end),
               run.mean_MB(begin, end), run.peak_MB(begin, end), run.graph().keyframes().size(),
               1e3 * run.ate_m());
}

void revisit(benchmark::State& state, const LifeParams& life, std::int64_t seed) {
  const int n = keyframes(), span = std::min(500, n / 10), early = n / 10;
  for (auto _ : state) {
    Run run(life, oneFloor(seed));
    for (int k = 0; k < n; ++k) {
      run.keyframe();
      tellProgress(run, k);
    }
    run.finish();
    const int begin = early - span / 2, end = early + span / 2;
    state.counters["early_ms"] = run.mean_ms(begin, end);
    state.counters["late_ms"] = run.mean_ms(n - span, n);
    state.counters["removal_ms"] = run.meanRemoval_ms(n - span, n);
    state.counters["early_MB"] = run.mean_MB(begin, end);
    state.counters["late_MB"] = run.mean_MB(n - span, n);
    state.counters["peak_MB"] = run.peak_MB(0, n);
    state.counters["ate_mm"] = 1e3 * run.ate_m();
    state.counters["keyframes"] = static_cast<double>(run.graph().keyframes().size());
    state.counters["nodes"] = static_cast<double>(run.graph().nodeCount());
    state.counters["edges"] = static_cast<double>(run.graph().edgeCount());
  }
}

/// By the number of keyframes that stay per square and heading, and the world.
void BM_Bounded(benchmark::State& state) {
  LifeParams life;
  life.bounded = true;
  life.per_cell = static_cast<int>(state.range(0));
  revisit(state, life, state.range(1));
}
BENCHMARK(BM_Bounded)
    ->ArgsProduct({{LifeParams().per_cell, 2 * LifeParams().per_cell},
                   benchmark::CreateDenseRange(1, seeds(), 1)})
    ->Iterations(1)
    ->Unit(benchmark::kSecond);

void BM_Unbounded(benchmark::State& state) { revisit(state, {}, state.range(0)); }
BENCHMARK(BM_Unbounded)->DenseRange(1, seeds())->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace dynemo
