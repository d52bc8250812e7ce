#include "study.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <thread>

#include "dynemo/core/child_process.h"
#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "task_pool.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;
using experiments::ExperimentPlan;
using experiments::RunKey;
using experiments::RunResult;

/// Every dataset's files have this name in their folder.
const std::string kName = "data";

fs::path program(const std::string& name) {
  return fs::read_symlink("/proc/self/exe").parent_path() / name;
}

void call(const std::vector<std::string>& command, const fs::path& log) {
  const ChildExit exit = ChildProcess(command, log).wait();
  if (exit.status == 0) return;
  const std::string how = exit.signal != 0 ? "was ended by signal " + std::to_string(exit.signal)
                                           : "ended with status " + std::to_string(exit.status);
  throw DataError(fs::path(command.front()).filename().string() + " " + how + "; see " +
                  log.string());
}

class Study {
 public:
  Study(const ExperimentPlan& plan, const StudyOptions& options)
      : plan_(plan), options_(options), runs_(experiments::runsOf(plan)) {}

  StudyOutcome carryOut() {
    done_ = static_cast<std::size_t>(std::count_if(
        runs_.begin(), runs_.end(), [this](const RunKey& r) { return fs::exists(resultFile(r)); }));
    std::map<std::pair<std::string, int>, std::vector<RunKey>> groups;
    std::vector<std::pair<std::string, int>> order;
    for (const RunKey& run : runs_) {
      if (fs::exists(resultFile(run))) continue;
      auto& group = groups[{run.dataset, run.seed}];
      if (group.empty()) order.emplace_back(run.dataset, run.seed);
      group.push_back(run);
    }
    for (const auto& key : order) addGroup(groups.at(key));
    StudyOutcome outcome;
    for (const TaskFailure& failure : runTasks(tasks_, options_.jobs))
      outcome.missing.push_back(failure.name + ": " + failure.reason);
    for (const RunKey& run : runs_)
      if (fs::exists(resultFile(run)))
        outcome.results.push_back(experiments::readResult(resultFile(run)));
    return outcome;
  }

 private:
  fs::path datasetFolder(const std::string& dataset, int seed) const {
    return options_.output / "datasets" / (dataset + "_seed" + std::to_string(seed));
  }
  fs::path runFolder(const RunKey& run) const { return options_.output / "runs" / run.path(); }
  fs::path resultFile(const RunKey& run) const { return runFolder(run) / "result.json"; }

  /// Simulation; then for each odometry the run that records the front-end; then the others, which
  /// replay it.
  void addGroup(const std::vector<RunKey>& runs) {
    const RunKey& first = runs.front();
    const std::string name = first.dataset + " seed " + std::to_string(first.seed);
    const std::size_t simulation = tasks_.size();
    tasks_.push_back({name, [this, first] { simulate(first.dataset, first.seed); }, {}, false});
    std::map<std::string, std::size_t> recording;
    std::vector<std::size_t> all{simulation};
    for (const RunKey& run : runs) {
      const auto it = recording.find(run.odometry);
      const std::size_t after = it == recording.end() ? simulation : it->second;
      recording.emplace(run.odometry, tasks_.size());
      all.push_back(tasks_.size());
      tasks_.push_back({run.path(), [this, run] { execute(run); }, {after}, it != recording.end()});
    }
    if (!plan_.keep_rawlogs)
      tasks_.push_back(
          {name + " clean-up", [this, first] { discard(first.dataset, first.seed); }, all, true});
  }

  void simulate(const std::string& dataset, int seed) {
    const fs::path folder = datasetFolder(dataset, seed);
    if (fs::exists(folder / (kName + "_meta.json")) && fs::exists(folder / (kName + ".rawlog")))
      return;
    fs::create_directories(folder);
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const int threads = std::max(1, static_cast<int>(cores) / options_.jobs);
    std::vector<std::string> command{program("dynemo-simulate"),
                                     dataset,
                                     "--name",
                                     kName,
                                     "--seed",
                                     std::to_string(seed),
                                     "--scale",
                                     plan_.scale,
                                     "--threads",
                                     std::to_string(threads),
                                     "--quiet",
                                     "--output",
                                     folder};
    if (plan_.duration_s)
      command.insert(command.end(), {"--duration", exactNumber(*plan_.duration_s)});
    call(command, folder / "simulate.log");
  }

  void execute(const RunKey& run) {
    const fs::path data = datasetFolder(run.dataset, run.seed), folder = runFolder(run);
    fs::create_directories(folder);
    std::vector<std::string> command{program("dynemo-slam"),
                                     "--entities",
                                     data / (kName + "_entities.yaml"),
                                     "--config",
                                     data / (kName + "_config.yaml"),
                                     "--setup",
                                     run.setup,
                                     "--set",
                                     "outputs=[trajectory,keyframes,odometry,entities]",
                                     "--front-end-cache",
                                     data / (run.odometry + ".cache"),
                                     "--quiet",
                                     "--output",
                                     folder};
    if (run.odometry == "rawlog") {
      command.insert(command.end(), {"--set", "odometry.source=rawlog"});
    } else {
      command.insert(command.end(), {"--set", "odometry.source=lidar", "--set",
                                     "odometry.lidar.method=" + run.odometry});
    }
    command.push_back(data / (kName + ".rawlog"));
    call(command, folder / "slam.log");
    const RunResult result = experiments::evaluate(run, folder, data, kName);
    experiments::writeResult(result, resultFile(run));
    const std::lock_guard lock(mutex_);
    if (options_.on_result) options_.on_result(result, ++done_, runs_.size());
  }

  /// Ground truth and world stay.
  void discard(const std::string& dataset, int seed) {
    const fs::path folder = datasetFolder(dataset, seed);
    fs::remove(folder / (kName + ".rawlog"));
    fs::remove_all(folder / (kName + "_Images"));
    for (const std::string& odometry : plan_.odometries) {
      fs::remove(folder / (odometry + ".cache"));
      fs::remove_all(folder / (odometry + ".cache.planes"));
    }
  }

  const ExperimentPlan& plan_;
  const StudyOptions& options_;
  std::vector<RunKey> runs_;
  std::vector<Task> tasks_;
  std::mutex mutex_;
  std::size_t done_ = 0;
};

}  // namespace

StudyOutcome carryOut(const ExperimentPlan& plan, const StudyOptions& options) {
  return Study(plan, options).carryOut();
}

fs::path worldFile(const fs::path& output, const std::string& dataset) {
  return output / "datasets" / (dataset + "_seed1") / (kName + "_world.yaml");
}

}  // namespace dynemo
