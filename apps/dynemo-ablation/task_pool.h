// Tasks that wait for one another, several at once.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace dynemo {

struct Task {
  std::string name;
  std::function<void()> work;      ///< throws when it fails
  std::vector<std::size_t> after;  ///< indices of earlier tasks
  /// Also when a task that it waits for failed.
  bool always = false;
};

struct TaskFailure {
  std::string name, reason;
};

/// Runs all tasks, `jobs` at once, the first ready one first. Tasks whose forerunners failed fail
/// too. Returns the failures in the order of the tasks.
std::vector<TaskFailure> runTasks(const std::vector<Task>& tasks, int jobs);

}  // namespace dynemo
