#include "dynemo/batch/slurm.h"

#include <chrono>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "dynemo/core/child_process.h"
#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::milliseconds kPollInterval{100};
/// A controller that restarts answers nothing for a while.
constexpr int kMostFailures = 20;

struct CommandResult {
  int status = 0;
  std::string text;  ///< stdout and stderr
};

CommandResult runCommand(const std::vector<std::string>& command, const fs::path& scratch) {
  const ChildExit exit = ChildProcess(command, scratch).wait();
  std::ifstream in(scratch);
  std::ostringstream text;
  text << in.rdbuf();
  std::string said = text.str();
  while (!said.empty() && said.back() == '\n') said.pop_back();
  return {exit.status, said};
}

/// A word for the shell.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

fs::path freeFolder(const fs::path& parent) {
  for (int i = 1;; ++i) {
    const fs::path folder = parent / ("job_" + std::to_string(i));
    std::error_code failure;
    fs::create_directories(parent, failure);
    if (fs::create_directory(folder, failure)) return folder;
    if (failure) throw DataError(folder.string() + ": cannot be made: " + failure.message());
  }
}

/// Whether Slurm still knows tasks of the job that wait or run; empty when it does not answer.
std::optional<bool> isQueued(const SlurmJob& job) {
  const auto answer = runCommand({"squeue", "--noheader", "--jobs=" + job.id, "--format=%i"},
                                 job.folder / "squeue.txt");
  if (answer.status == 0) return !answer.text.empty();
  // A job that has ended is forgotten after some minutes.
  if (answer.text.find("Invalid job id") != std::string::npos) return false;
  return std::nullopt;
}

BatchResult countStates(const std::vector<WorkItem>& items, const RunStore& store) {
  BatchResult result;
  for (const WorkItem& item : items) {
    const RunState state = store.state(item);
    result.done += state == RunState::kDone ? 1 : 0;
    result.failed += state == RunState::kFailed ? 1 : 0;
  }
  return result;
}

}  // namespace

std::string slurmScript(const SlurmJob& job, const RunStore& store, const SlurmParams& params) {
  std::string array = "0-" + std::to_string(job.tasks - 1);
  if (params.jobs > 0) array += "%" + std::to_string(params.jobs);
  return "#!/bin/sh\n#SBATCH --job-name=dynemo\n#SBATCH --array=" + array +
         "\n#SBATCH --output=" + (job.folder / "task_%a.txt").string() + "\nexec " +
         quoted(params.program.string()) + " --work " + quoted(store.work().string()) + " --task " +
         quoted((job.folder / "work.json").string()) + " --index \"$SLURM_ARRAY_TASK_ID\"\n";
}

std::string sbatchReason(const std::string& printed) {
  std::string reasons;
  std::istringstream in(printed);
  for (std::string line; std::getline(in, line);) {
    for (const std::string prefix : {"sbatch: ", "error: "})
      if (line.starts_with(prefix)) line.erase(0, prefix.size());
    line.erase(line.find_last_not_of(" .\r") + 1);
    if (!line.empty()) reasons += (reasons.empty() ? "" : "; ") + line;
  }
  return reasons.empty() ? "no reason given" : reasons;
}

SlurmJob submitToSlurm(const std::vector<WorkItem>& items, const RunStore& store,
                       const SlurmParams& params) {
  std::vector<WorkItem> missing;
  for (const WorkItem& item : items)
    if (store.state(item) != RunState::kDone) missing.push_back(item);
  SlurmJob job;
  job.tasks = missing.size();
  if (missing.empty()) return job;
  job.folder = freeFolder(store.work() / ".slurm");
  writeFileAtomically(job.folder / "work.json", workListJson(missing));
  writeFileAtomically(job.folder / "job.sh", slurmScript(job, store, params));
  std::vector<std::string> command = {"sbatch", "--parsable"};
  command.insert(command.end(), params.options.begin(), params.options.end());
  command.push_back((job.folder / "job.sh").string());
  const auto answer = runCommand(command, job.folder / "sbatch.txt");
  if (answer.status == ChildExit::kCannotStart)
    throw DataError(sbatchReason(answer.text) + "; is Slurm installed here?");
  if (answer.status != 0)
    throw DataError("Slurm's sbatch refuses the job: " + sbatchReason(answer.text));
  // The last line is "id" or "id;cluster"; warnings come before it.
  const auto line = answer.text.find_last_of('\n');
  job.id = answer.text.substr(line == std::string::npos ? 0 : line + 1);
  job.id = job.id.substr(0, job.id.find(';'));
  if (job.id.empty() || job.id.find_first_not_of("0123456789") != std::string::npos)
    throw DataError("sbatch: gave no job id but '" + answer.text + "'");
  return job;
}

BatchResult waitForSlurm(const SlurmJob& job, const std::vector<WorkItem>& items,
                         const RunStore& store, const SlurmParams& params,
                         const BatchCallbacks& callbacks) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const std::size_t done_before = countStates(items, store).done;
  std::vector<RunState> reported(items.size(), RunState::kMissing);
  for (std::size_t i = 0; i < items.size(); ++i)
    if (store.state(items[i]) == RunState::kDone) reported[i] = RunState::kDone;
  BatchResult result;
  const auto look = [&] {
    result = countStates(items, store);
    for (std::size_t i = 0; i < items.size() && callbacks.ended; ++i) {
      const RunState state = store.state(items[i]);
      if (state == reported[i]) continue;
      reported[i] = state;
      if (state != RunState::kMissing)
        callbacks.ended(items[i], state == RunState::kDone ? "" : store.failure(items[i]));
    }
    if (!callbacks.progress) return;
    BatchProgress p;
    p.total = items.size();
    p.done = result.done;
    p.failed = result.failed;
    p.elapsed_s = std::chrono::duration<double>(Clock::now() - start).count();
    const double ended = static_cast<double>(p.done + p.failed);
    p.fraction = ended / static_cast<double>(p.total);
    const double worked = ended - static_cast<double>(done_before);
    if (worked > 0) p.remaining_s = p.elapsed_s * (static_cast<double>(p.total) - ended) / worked;
    callbacks.progress(p);
  };
  auto asked = start - std::chrono::hours(1);
  for (int failures = 0;;) {
    if (params.interrupted && *params.interrupted) {
      runCommand({"scancel", job.id}, job.folder / "scancel.txt");
      look();
      result.interrupted = true;
      return result;
    }
    if (std::chrono::duration<double>(Clock::now() - asked).count() >= params.poll_interval_s) {
      asked = Clock::now();
      const auto queued = isQueued(job);
      if (queued && !*queued) break;
      failures = queued ? 0 : failures + 1;
      if (failures > kMostFailures)
        throw DataError("squeue does not answer; the job " + job.id +
                        " may go on, and a second call collects it");
    }
    look();
    std::this_thread::sleep_for(kPollInterval);
  }
  look();
  return result;
}

}  // namespace dynemo
