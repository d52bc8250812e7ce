// Runs a program as a user would, with a time limit, and keeps what it printed.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace dynemo::test {

/// How a program ended and what it printed.
struct Outcome {
  int status = -1;  ///< exit status; -1 when a signal ended the program
  int signal = 0;   ///< the signal that ended it, 0 when it exited
  bool timed_out = false;
  std::string out, err;
};

/// For test messages.
std::string describe(const Outcome& outcome);

/// A running program: stdin closed, stdout and stderr collected. The destructor kills it.
class Process {
 public:
  /// `command` is searched in PATH when it has no slash. Throws std::system_error when it cannot be
  /// started.
  explicit Process(std::vector<std::string> command,
                   const std::filesystem::path& working_folder = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Reads on until stderr contains the text; false when the program ends or the time is over
  /// first.
  bool waitForError(const std::string& text, std::chrono::seconds limit);
  void send(int signal) const;
  /// Waits for the end; kills the program when the time is over.
  Outcome finish(std::chrono::seconds limit);

 private:
  using Clock = std::chrono::steady_clock;
  /// Reads what is there; false when both pipes are at their end or the deadline has passed.
  bool pump(Clock::time_point deadline);
  bool waitForExit(Clock::time_point deadline) const;

  pid_t pid_ = -1;
  int out_ = -1, err_ = -1;
  Outcome outcome_;
};

constexpr std::chrono::seconds kTimeLimit{240};

Outcome runCommand(const std::vector<std::string>& command,
                   const std::filesystem::path& working_folder = {},
                   std::chrono::seconds limit = kTimeLimit);

}  // namespace dynemo::test
