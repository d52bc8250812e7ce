// What the benchmarks of the back-end share.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "dynemo/backend/optimizer.h"

namespace dynemo {

using States = std::vector<std::vector<double>>;

inline States statesOf(const CSceneGraph& graph) {
  States states;
  for (const auto& node : graph.nodeSlots()) {
    states.emplace_back(static_cast<std::size_t>(node->stateSize()));
    node->readState(states.back().data());
  }
  return states;
}

inline void restore(CSceneGraph& graph, const States& states) {
  for (std::size_t i = 0; i < states.size(); ++i) graph.setState({i}, states[i].data());
}

/// Of the processor, for the calling thread.
inline double threadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Runs `work` and returns how long the processor was at it in this thread [s].
template <class Work>
double secondsOf(Work work) {
  const double start = threadSeconds();
  work();
  return threadSeconds() - start;
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

}  // namespace dynemo
