// A work list as an array of jobs of the Slurm workload manager.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dynemo/batch/batch_runner.h"

namespace dynemo {

struct SlurmParams {
  std::filesystem::path program;  ///< dynemo-batch, which runs one item in each task
  /// Passed on to sbatch, e.g. "--partition=long".
  std::vector<std::string> options;
  /// Tasks at a time; 0: as many as the cluster gives.
  int jobs = 0;
  double poll_interval_s = 5.0;
  const std::atomic<bool>* interrupted = nullptr;
};

struct SlurmJob {
  std::string id;
  std::filesystem::path folder;  ///< job script, work list and what each task printed
  std::size_t tasks = 0;
};

/// The script of the array: task i runs item i of work.json in the job's folder.
std::string slurmScript(const SlurmJob& job, const RunStore& store, const SlurmParams& params);

/// The reasons among what sbatch printed, in one line.
std::string sbatchReason(const std::string& printed);

/// Writes and submits a job array of the items that are not done; an id is empty when all are.
/// Throws DataError with what sbatch said when it refuses or is not installed.
SlurmJob submitToSlurm(const std::vector<WorkItem>& items, const RunStore& store,
                       const SlurmParams& params);

/// Waits until Slurm has no task of the job any more; cancels it when interrupted. Then counts the
/// states of the items. Throws DataError when squeue fails again and again.
BatchResult waitForSlurm(const SlurmJob& job, const std::vector<WorkItem>& items,
                         const RunStore& store, const SlurmParams& params,
                         const BatchCallbacks& callbacks = {});

}  // namespace dynemo
