// dynemo-batch: many rawlogs and setups, on this machine or on a cluster.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <optional>

#include "../common/number_range.h"
#include "../common/program.h"
#include "dynemo/batch/batch_runner.h"
#include "dynemo/batch/configuration_check.h"
#include "dynemo/batch/slurm.h"
#include "dynemo/batch/summary.h"
#include "dynemo/core/output_file.h"

namespace fs = std::filesystem;

namespace dynemo {
namespace {

std::atomic<bool> interrupted{false};
constexpr int kSomeFailed = 1;
constexpr int kInterruptedStatus = 130;

struct Options {
  std::vector<std::string> rawlogs;
  WorkPlan plan;
  fs::path work;
  int jobs = 1;
  bool slurm = false, no_wait = false, collect = false, dry_run = false, quiet = false;
  std::vector<std::string> slurm_options;
  std::optional<fs::path> task_list;
  std::size_t task_index = 0;
  std::optional<fs::path> program;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("RAWLOGS", o.rawlogs,
                 "Rawlogs, patterns such as 'data/*/*.rawlog', or @FILE with one of them per line")
      ->type_name("");
  app.add_option("--work", o.work,
                 "Folder for the runs and the summary; a second call continues it")
      ->required()
      ->type_name("DIR");
  app.add_option("--setup", o.plan.setups,
                 "Setup of dynemo-slam, or a configuration file FILE.yaml (repeatable)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app.add_option("--config", o.plan.config, "Configuration file for all runs")->type_name("FILE");
  app.add_option("--set", o.plan.overrides, "Override one key in all runs (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--entities", o.plan.entities,
                 "Entity file for all rawlogs; else NAME_entities.yaml beside each")
      ->type_name("FILE");
  app.add_option("-j,--jobs", o.jobs, "Runs at a time")
      ->check(positiveNumber())
      ->type_name("N")
      ->capture_default_str();
  app.add_flag("--dry-run", o.dry_run, "List the runs and their states, and exit");
  app.add_flag("--collect", o.collect, "Run nothing, only write the summary of what is there");
  app.add_option("--program", o.program, "dynemo-slam to run; else the one beside dynemo-batch")
      ->type_name("FILE");
  app.add_flag("-q,--quiet", o.quiet, "Print errors only");
  app.add_flag("--slurm", o.slurm, "Submit the runs as a Slurm job array and wait for it")
      ->group("Cluster");
  app.add_option("--slurm-option", o.slurm_options,
                 "Option for sbatch, e.g. --slurm-option=--partition=long (repeatable)")
      ->type_name("OPTION")
      ->allow_extra_args(false)
      ->group("Cluster");
  app.add_flag("--no-wait", o.no_wait, "Submit only; a later call with --collect sums up")
      ->group("Cluster");
  app.add_option("--task", o.task_list, "Run one item of a work list (what the tasks call)")
      ->type_name("FILE.json")
      ->group("Cluster");
  app.add_option("--index", o.task_index, "Which item of the work list")
      ->type_name("N")
      ->group("Cluster");
  app.set_version_flag("--version", "dynemo-batch " DYNEMO_VERSION);
  app.footer(
      "Each run has a folder WORK/<rawlog>/<setup>; WORK/summary.csv has one row per run, with the "
      "figures of\ndynemo-eval where NAME_gt_robot.tum and NAME_gt_entities.csv lie beside the "
      "rawlog.\nExit status: 0 all runs done, 1 some failed, 2 usage, 3 data, 4 internal error.");
}

fs::path ownFolder() {
  std::error_code failure;
  return fs::read_symlink("/proc/self/exe", failure).parent_path();
}

/// One line that redraws itself on a terminal; elsewhere a line when the percentage has grown.
class BatchDisplay {
 public:
  explicit BatchDisplay(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}
  ~BatchDisplay() { clear(); }
  BatchDisplay(const BatchDisplay&) = delete;
  BatchDisplay& operator=(const BatchDisplay&) = delete;

  void progress(const BatchProgress& p) {
    const int percent = static_cast<int>(100.0 * p.fraction);
    if (quiet_ || (!terminal_ && percent < printed_percent_ + 10)) return;
    printed_percent_ = percent;
    char line[160];
    std::snprintf(line, sizeof(line), "%3d %%  %zu of %zu done, %zu failed, %zu running", percent,
                  p.done, p.total, p.failed, p.running);
    std::cerr << (terminal_ ? "\r" : "") << line << remainingText(p)
              << (terminal_ ? "\033[K" : "\n") << std::flush;
    drawn_ = terminal_;
  }
  void ended(const WorkItem& item, const std::string& failure) {
    clear();
    if (!failure.empty())
      std::cerr << "failed      " << item.name << ": " << failure << '\n';
    else if (!quiet_)
      std::cerr << "done        " << item.name << '\n';
  }
  void clear() {
    if (drawn_) std::cerr << "\r\033[K" << std::flush;
    drawn_ = false;
  }

 private:
  static std::string remainingText(const BatchProgress& p) {
    if (!p.remaining_s) return {};
    char text[48];
    std::snprintf(text, sizeof(text), "  ETA %.0f s", *p.remaining_s);
    return text;
  }

  bool quiet_, terminal_, drawn_ = false;
  int printed_percent_ = -10;
};

void requireConsistent(const Options& o) {
  if (o.rawlogs.empty()) throw ConfigError("RAWLOGS is required (see dynemo-batch --help)");
  if (!o.slurm && (o.no_wait || !o.slurm_options.empty()))
    throw ConfigError("--no-wait and --slurm-option need --slurm");
  if (o.plan.entities && !fs::is_regular_file(*o.plan.entities))
    throw ConfigError("--entities " + o.plan.entities->string() + ": no such file");
}

BatchParams batchParams(const Options& o) {
  return {o.program ? fs::absolute(*o.program) : ownFolder() / "dynemo-slam", o.jobs, &interrupted};
}

int runTask(const Options& o) {
  const auto items = readWorkList(*o.task_list);
  if (o.task_index >= items.size())
    throw ConfigError("--index " + std::to_string(o.task_index) + ": the list has " +
                      std::to_string(items.size()) + " items");
  const RunStore store(o.work);
  const auto result = runBatch({items[o.task_index]}, store, batchParams(o), {});
  if (result.interrupted) return kInterruptedStatus;
  return result.failed > 0 ? kSomeFailed : 0;
}

int listRuns(const std::vector<WorkItem>& items, const RunStore& store) {
  for (const WorkItem& item : items) {
    const RunState state = store.state(item);
    std::cout << (state == RunState::kDone     ? "done     "
                  : state == RunState::kFailed ? "failed   "
                                               : "missing  ")
              << item.name << "  dynemo-slam";
    for (const std::string& argument : item.arguments) std::cout << ' ' << argument;
    std::cout << '\n';
  }
  return 0;
}

BatchResult work(const Options& o, const std::vector<WorkItem>& items, const RunStore& store,
                 BatchDisplay& display) {
  const BatchCallbacks callbacks = {
      [&](const BatchProgress& p) { display.progress(p); },
      [&](const WorkItem& item, const std::string& failure) { display.ended(item, failure); }};
  if (!o.slurm) return runBatch(items, store, batchParams(o), callbacks);
  SlurmParams params;
  params.program = ownFolder() / "dynemo-batch";
  params.options = o.slurm_options;
  params.jobs = o.jobs > 1 ? o.jobs : 0;
  params.interrupted = &interrupted;
  const SlurmJob job = submitToSlurm(items, store, params);
  if (!job.id.empty() && !o.quiet)
    std::cout << "submitted   Slurm job " << job.id << " with " << job.tasks << " tasks\n"
              << std::flush;
  if (job.id.empty() || o.no_wait) return {};
  return waitForSlurm(job, items, store, params, callbacks);
}

int summarize(const Options& o, const std::vector<WorkItem>& items, const RunStore& store) {
  const Table summary = summaryTable(items, store);
  writeFileAtomically(store.work() / "summary.csv", tableCsv(summary));
  writeFileAtomically(store.work() / "performance.csv", tableCsv(performanceTable(items, store)));
  if (!o.quiet)
    std::cout << tableText(summary) << "summary     " << (o.work / "summary.csv").string() << '\n'
              << std::flush;
  if (!std::cout) throw DataError("standard output: cannot be written");
  const bool all_done = std::all_of(items.begin(), items.end(), [&](const WorkItem& item) {
    return store.state(item) == RunState::kDone;
  });
  return all_done ? 0 : kSomeFailed;
}

void warnOfMissingEntities(const std::vector<WorkItem>& items) {
  constexpr std::size_t kMostNamed = 3;
  const auto rawlogs = rawlogsWithoutEntities(items);
  if (rawlogs.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < std::min(kMostNamed, rawlogs.size()); ++i)
    names += (i > 0 ? ", " : "") + fs::path(rawlogs[i]).filename().string();
  if (rawlogs.size() > kMostNamed)
    names += " and " + std::to_string(rawlogs.size() - kMostNamed) + " more";
  std::cerr << "warning     no entity file NAME_entities.yaml beside " << names
            << " and no --entities: their maps will hold no entities\n";
}

int run(const Options& o) {
  if (o.task_list) return runTask(o);
  requireConsistent(o);
  const auto items = makeWorkList(expandRawlogs(o.rawlogs), o.plan);
  if (!o.collect) requireConfigurations(items, batchParams(o).program);
  if (!o.collect && !o.quiet) warnOfMissingEntities(items);
  const RunStore store(o.work);
  if (o.dry_run) return listRuns(items, store);
  BatchResult result;
  if (!o.collect) {
    BatchDisplay display(o.quiet);
    result = work(o, items, store, display);
  }
  if (result.interrupted) {
    std::cerr << "dynemo-batch: interrupted; the same call continues\n";
    return kInterruptedStatus;
  }
  if (o.slurm && o.no_wait) return 0;
  return summarize(o, items, store);
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  for (const int signal : {SIGINT, SIGTERM})
    std::signal(signal, [](int) { dynemo::interrupted = true; });
  CLI::App app("Runs dynemo-slam on many rawlogs with many setups and sums the results up.",
               "dynemo-batch");
  dynemo::Options options;
  dynemo::declare(app, options);
  return dynemo::runProgram(app, argc, argv, [&] { return dynemo::run(options); });
}
