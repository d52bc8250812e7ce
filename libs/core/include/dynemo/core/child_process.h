#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dynemo {

/// How a program ended.
struct ChildExit {
  /// Status of a program that is not there, as in a shell.
  static constexpr int kCannotStart = 127;

  int status = 0;  ///< exit status, or −1 when a signal ended it
  int signal = 0;
};

/// A program whose output goes to a file, and which the kernel kills when the thread that started
/// it ends, in whatever way: no program outlives the one that waits for it.
class ChildProcess {
 public:
  /// Throws DataError when the file cannot be written. A program that is not there exits with
  /// kCannotStart, and the file says why.
  ChildProcess(const std::vector<std::string>& command, const std::filesystem::path& output);
  /// Ends the program when it still runs.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Its end, without waiting; empty while it runs.
  std::optional<ChildExit> poll();
  /// Its end.
  ChildExit wait();
  void send(int signal) const;

 private:
  std::optional<ChildExit> waitWith(int options);

  pid_t pid_ = -1;
};

}  // namespace dynemo
