#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dynemo {

/// How a program ended.
struct ChildExit {
  int status = 0;  ///< exit status, or −1 when a signal ended it
  int signal = 0;
};

/// A program whose output goes to a file, and which the kernel ends when this process ends.
class ChildProcess {
 public:
  /// Throws DataError when it cannot be started.
  ChildProcess(const std::vector<std::string>& command, const std::filesystem::path& output);
  /// Ends the program when it still runs.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Its end, without waiting; empty while it runs.
  std::optional<ChildExit> poll();
  void send(int signal) const;

 private:
  pid_t pid_ = -1;
};

}  // namespace dynemo
