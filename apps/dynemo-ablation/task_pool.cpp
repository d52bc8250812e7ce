#include "task_pool.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

namespace dynemo {
namespace {

enum class State : std::uint8_t { kWaiting, kRunning, kDone, kFailed };

class Pool {
 public:
  explicit Pool(const std::vector<Task>& tasks)
      : tasks_(tasks), states_(tasks.size(), State::kWaiting), reasons_(tasks.size()) {}

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      const auto index = ready();
      if (!index) {
        if (std::none_of(states_.begin(), states_.end(),
                         [](State s) { return s == State::kWaiting; }))
          break;
        changed_.wait(lock);
        continue;
      }
      states_[*index] = State::kRunning;
      lock.unlock();
      const std::string reason = attempt(tasks_[*index]);
      lock.lock();
      states_[*index] = reason.empty() ? State::kDone : State::kFailed;
      reasons_[*index] = reason;
      changed_.notify_all();
    }
    changed_.notify_all();
  }

  std::vector<TaskFailure> failures() const {
    std::vector<TaskFailure> list;
    for (std::size_t i = 0; i < tasks_.size(); ++i)
      if (states_[i] == State::kFailed) list.push_back({tasks_[i].name, reasons_[i]});
    return list;
  }

 private:
  static std::string attempt(const Task& task) {
    try {
      task.work();
      return "";
    } catch (const std::exception& error) {
      return error.what();
    }
  }

  /// The first waiting task whose forerunners are done; those that cannot run any more fail on the
  /// way.
  std::optional<std::size_t> ready() {
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      if (states_[i] != State::kWaiting) continue;
      bool waits = false;
      for (const std::size_t before : tasks_[i].after) {
        if (states_[before] == State::kFailed && !tasks_[i].always) {
          states_[i] = State::kFailed;
          reasons_[i] = tasks_[before].name + " failed";
          changed_.notify_all();
        }
        waits |= states_[before] == State::kWaiting || states_[before] == State::kRunning;
      }
      if (!waits && states_[i] == State::kWaiting) return i;
    }
    return std::nullopt;
  }

  const std::vector<Task>& tasks_;
  std::vector<State> states_;
  std::vector<std::string> reasons_;
  std::mutex mutex_;
  std::condition_variable changed_;
};

}  // namespace

std::vector<TaskFailure> runTasks(const std::vector<Task>& tasks, int jobs) {
  Pool pool(tasks);
  std::vector<std::jthread> workers;
  for (int i = 0; i < jobs; ++i) workers.emplace_back([&pool] { pool.work(); });
  workers.clear();
  return pool.failures();
}

}  // namespace dynemo
