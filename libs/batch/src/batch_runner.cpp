#include "dynemo/batch/batch_runner.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <list>
#include <sstream>
#include <thread>

#include "dynemo/core/child_process.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kPollInterval{50};

/// The end of a file that may be long.
std::string tail(const fs::path& file) {
  constexpr std::streamoff kBytes = 4096;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return {};
  const std::streamoff size = in.tellg();
  in.seekg(size > kBytes ? size - kBytes : 0);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string lastLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const auto begin = text.find_last_of("\r\n");
  return begin == std::string::npos ? text : text.substr(begin + 1);
}

struct Running {
  std::size_t item;
  RunLock lock;
  ChildProcess process;
};

class Batch {
 public:
  Batch(const std::vector<WorkItem>& items, const RunStore& store, const BatchParams& params,
        const BatchCallbacks& callbacks)
      : items_(items), store_(store), params_(params), callbacks_(callbacks) {
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (store_.state(items_[i]) == RunState::kDone)
        ++result_.done;
      else
        waiting_.push_back(i);
    }
    done_before_ = result_.done;
  }

  BatchResult run() {
    while (!waiting_.empty() || !running_.empty()) {
      if (params_.interrupted && *params_.interrupted) interrupt();
      startMore();
      reap();
      report();
      if (!running_.empty()) std::this_thread::sleep_for(kPollInterval);
    }
    return result_;
  }

 private:
  void startMore() {
    while (!waiting_.empty() && running_.size() < static_cast<std::size_t>(params_.jobs)) {
      const std::size_t i = waiting_.front();
      waiting_.pop_front();
      start(i);
    }
  }

  void start(std::size_t i) {
    const WorkItem& item = items_[i];
    auto lock = RunLock::acquire(store_, item);
    if (!lock) {
      ++result_.elsewhere;
      return;
    }
    // Another process may have finished it in the meantime.
    if (store_.state(item) == RunState::kDone) {
      ++result_.done;
      return;
    }
    store_.begin(item);
    std::vector<std::string> command = {params_.program.string(), "--output",
                                        store_.unfinishedFolder(item).string()};
    command.insert(command.end(), item.arguments.begin(), item.arguments.end());
    running_.push_back({i, std::move(*lock), ChildProcess(command, store_.consoleFile(item))});
  }

  void reap() {
    for (auto it = running_.begin(); it != running_.end();) {
      const auto exit = it->process.poll();
      if (!exit) {
        ++it;
        continue;
      }
      end(items_[it->item], *exit);
      it = running_.erase(it);
    }
  }

  void end(const WorkItem& item, const ChildExit& exit) {
    // What an interrupted run leaves is not a result.
    if (result_.interrupted) return;
    std::string failure;
    if (exit.signal != 0)
      failure = std::string("ended by signal ") + strsignal(exit.signal);
    else if (exit.status != 0)
      failure = "exit status " + std::to_string(exit.status) + ": " +
                lastLine(tail(store_.consoleFile(item)));
    if (failure.empty())
      store_.finish(item);
    else
      store_.fail(item, failure);
    ++(failure.empty() ? result_.done : result_.failed);
    if (callbacks_.ended) callbacks_.ended(item, failure);
  }

  void interrupt() {
    if (result_.interrupted) return;
    result_.interrupted = true;
    waiting_.clear();
    for (const Running& run : running_) run.process.send(SIGTERM);
  }

  void report() {
    if (!callbacks_.progress) return;
    BatchProgress p;
    p.total = items_.size();
    p.done = result_.done;
    p.failed = result_.failed;
    p.running = running_.size();
    double parts = 0.0;
    for (const Running& run : running_)
      parts += printedFraction(store_.consoleFile(items_[run.item]));
    const double ended = static_cast<double>(result_.done + result_.failed + result_.elsewhere);
    const double total = static_cast<double>(items_.size());
    p.fraction = total > 0 ? (ended + parts) / total : 1.0;
    p.elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
    const double worked = ended + parts - static_cast<double>(done_before_);
    if (worked > 0) p.remaining_s = p.elapsed_s * (total - ended - parts) / worked;
    callbacks_.progress(p);
  }

  const std::vector<WorkItem>& items_;
  const RunStore& store_;
  const BatchParams& params_;
  const BatchCallbacks& callbacks_;
  std::deque<std::size_t> waiting_;
  std::list<Running> running_;
  BatchResult result_;
  std::size_t done_before_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace

double printedFraction(const fs::path& console) {
  const std::string text = tail(console);
  const auto percent = text.rfind(" %");
  if (percent == std::string::npos) return 0.0;
  const auto begin = text.find_last_not_of("0123456789", percent - 1);
  const std::string digits = text.substr(begin == std::string::npos ? 0 : begin + 1,
                                         percent - (begin == std::string::npos ? 0 : begin + 1));
  return digits.empty() ? 0.0 : std::min(1.0, std::atof(digits.c_str()) / 100.0);
}

BatchResult runBatch(const std::vector<WorkItem>& items, const RunStore& store,
                     const BatchParams& params, const BatchCallbacks& callbacks) {
  return Batch(items, store, params, callbacks).run();
}

}  // namespace dynemo
