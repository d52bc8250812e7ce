// Results with known figures.
#pragma once

#include "dynemo/experiments/run_result.h"

namespace dynemo::experiments::test {

inline RunResult madeUp(const std::string& dataset, int seed, const std::string& setup,
                        double ate_m) {
  RunResult r;
  r.key = {dataset, seed, "keyframe_gicp", setup};
  r.ate_rmse_m = ate_m;
  r.ate_std_m = 0.5 * ate_m;
  r.odometry_ate_m = 2.0 * ate_m;
  r.optimization_ms = 3.0;
  r.optimization_cpu_ms = 2.5;
  r.optimizations = 2;
  r.entities = {{1, "object", 0.08, 0.02}, {2, "object", 0.04, 0.02}, {101, "agent", 0.5, 0.5}};
  r.entity_samples = {{1, "object", 1.0, 0.08, 4.0, {2.0, 3.0, 2.1, 3.1}},
                      {101, "agent", 9.0, 0.03, 1.0, {5.0, 1.0, 5.0, 1.2}}};
  r.optimization_samples = {{10, 2.0}, {20, 4.0}};
  r.path = {{0, 0, 0, 0.1}, {1, 0, 1, 0.1}};
  return r;
}

}  // namespace dynemo::experiments::test
