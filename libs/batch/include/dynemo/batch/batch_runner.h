// Runs the items of a work list, several at a time.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/batch/run_store.h"

namespace dynemo {

struct BatchProgress {
  std::size_t total = 0, done = 0, failed = 0, running = 0;
  /// Of the whole work, unfinished runs by how far they say they are, in [0, 1].
  double fraction = 0.0;
  double elapsed_s = 0.0;
  /// Of the work that this call does; empty while nothing can be said.
  std::optional<double> remaining_s{};
};

struct BatchCallbacks {
  /// Several times a second.
  std::function<void(const BatchProgress&)> progress{};
  /// A run has ended; the reason is empty when it succeeded.
  std::function<void(const WorkItem&, const std::string& failure)> ended{};
};

struct BatchResult {
  std::size_t done = 0, failed = 0;
  std::size_t elsewhere = 0;  ///< being run by another process
  bool interrupted = false;
};

struct BatchParams {
  std::filesystem::path program;  ///< dynemo-slam
  int jobs = 1;
  /// When it becomes true no run is started any more, and those that run are interrupted.
  const std::atomic<bool>* interrupted = nullptr;
};

/// Runs every item that is not done yet, in the order of the list. A run that fails is noted in the
/// store and the rest goes on. Throws ConfigError when a finished run was made with other arguments
/// (before anything is started), and DataError when the work folder cannot be written.
BatchResult runBatch(const std::vector<WorkItem>& items, const RunStore& store,
                     const BatchParams& params, const BatchCallbacks& callbacks = {});

/// How far a run says it is, from what it printed last; zero when it has said nothing.
double printedFraction(const std::filesystem::path& console);

}  // namespace dynemo
