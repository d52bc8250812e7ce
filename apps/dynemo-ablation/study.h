// Carries out the runs of a plan by dynemo-simulate and dynemo-slam.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dynemo/experiments/experiment_plan.h"
#include "dynemo/experiments/run_result.h"

namespace dynemo {

struct StudyOptions {
  std::filesystem::path output;
  int jobs = 1;
  /// Called from any thread when a run has its result, with the number of results so far.
  std::function<void(const experiments::RunResult&, std::size_t done, std::size_t of)> on_result;
};

struct StudyOutcome {
  std::vector<experiments::RunResult> results;  ///< in the order of the plan
  std::vector<std::string> missing;
};

/// Runs what has no result in the output folder yet. Layout: datasets/DATASET_seedN,
/// runs/DATASET/seedN/ODOMETRY/SETUP.
StudyOutcome carryOut(const experiments::ExperimentPlan& plan, const StudyOptions& options);

/// The world file of a dataset's first seed.
std::filesystem::path worldFile(const std::filesystem::path& output, const std::string& dataset);

}  // namespace dynemo
