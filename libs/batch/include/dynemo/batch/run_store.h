// The state of a batch on the disk. There is no other: a batch can be stopped at any time, also by
// force, and goes on with what is missing.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "dynemo/batch/work_list.h"

namespace dynemo {

enum class RunState { kMissing, kDone, kFailed };

/// WORK/NAME/ is a finished run; what is going on or failed lies in WORK/.runs/NAME/.
class RunStore {
 public:
  /// Makes the folder. Throws DataError when that is not possible.
  explicit RunStore(const std::filesystem::path& work);

  const std::filesystem::path& work() const { return work_; }
  /// Results of a run.
  std::filesystem::path folder(const WorkItem& item) const { return work_ / item.name; }
  /// Where a run writes until it is done.
  std::filesystem::path unfinishedFolder(const WorkItem& item) const;
  /// What a run printed.
  std::filesystem::path consoleFile(const WorkItem& item) const;

  /// Throws ConfigError when a finished run was made with other arguments.
  RunState state(const WorkItem& item) const;
  /// Why the run failed, in one line.
  std::string failure(const WorkItem& item) const;

  /// Clears what an earlier attempt has left.
  void begin(const WorkItem& item) const;
  /// Makes the unfinished folder the result, in one step.
  void finish(const WorkItem& item) const;
  void fail(const WorkItem& item, const std::string& why) const;

 private:
  std::filesystem::path attempt(const WorkItem& item, const char* what) const;
  std::filesystem::path work_;
};

/// The right to run one item, among all processes that share the file system; released on
/// destruction and when the process ends in any way.
class RunLock {
 public:
  /// Empty when another process has it.
  static std::optional<RunLock> acquire(const RunStore& store, const WorkItem& item);
  ~RunLock();
  RunLock(RunLock&& other) noexcept;
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  explicit RunLock(int file) : file_(file) {}
  int file_;
};

}  // namespace dynemo
