// What is kept of one run.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/experiments/experiment_plan.h"

namespace dynemo::experiments {

struct EntityResult {
  int id = 0;
  std::string semantic_class;
  double first_m = 0.0;  ///< error at the first registration
  double last_m = 0.0;   ///< error of the last node after the final optimisation
};

/// One entity at one registration.
struct EntitySample {
  int id = 0;
  std::string semantic_class;
  double t_s = 0.0;
  /// Error as the run believed at that time.
  double translation_m = 0.0, rotation_deg = 0.0;
  /// x y in the world: estimate at the end after alignment, truth.
  std::array<double, 4> place{};
};

struct OptimizationSample {
  double nodes = 0.0, ms = 0.0;
};

struct RunResult {
  RunKey key;
  double ate_rmse_m = 0.0, ate_std_m = 0.0, odometry_ate_m = 0.0;
  std::optional<int> loop_closures;  ///< empty when loops are not closed
  double optimization_ms = 0.0;      ///< mean
  double optimization_cpu_ms = 0.0;  ///< mean, of the processor
  std::size_t optimizations = 0;
  std::vector<EntityResult> entities;
  std::vector<EntitySample> entity_samples;
  std::vector<OptimizationSample> optimization_samples;
  /// x y in the world: estimate after alignment, truth.
  std::vector<std::array<double, 4>> path;
};

/// Evaluates the run in a folder of dynemo-slam against NAME_gt_robot.tum and NAME_gt_entities.csv
/// in the dataset's folder. Throws DataError when a file is missing or malformed.
RunResult evaluate(const RunKey& key, const std::filesystem::path& run,
                   const std::filesystem::path& dataset, const std::string& name);

/// One JSON file; written in one step, so that a file that exists is complete.
void writeResult(const RunResult& result, const std::filesystem::path& file);
/// Throws DataError when the file is not what writeResult() writes.
RunResult readResult(const std::filesystem::path& file);

}  // namespace dynemo::experiments
