#include "dynemo/core/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

/// Only what is allowed between fork and exec.
[[noreturn]] void becomeProgram(char* const* arguments, int output, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent)
    ::_exit(ChildExit::kCannotStart);  // the parent ended before the line above
  const int input = ::open("/dev/null", O_RDONLY);
  ::dup2(input, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  ::execvp(arguments[0], arguments);
  ::dprintf(STDERR_FILENO, "%s: cannot be started: %s\n", arguments[0], std::strerror(errno));
  ::_exit(ChildExit::kCannotStart);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command,
                           const std::filesystem::path& output) {
  const int file = ::open(output.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666);
  if (file < 0) throw DataError(output.string() + ": cannot be created");
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ == 0) becomeProgram(arguments.data(), file, parent);
  ::close(file);
  if (pid_ < 0) throw DataError(command.front() + ": cannot be started: " + std::strerror(errno));
}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept : pid_(other.pid_) { other.pid_ = -1; }

std::optional<ChildExit> ChildProcess::poll() { return waitWith(WNOHANG); }

ChildExit ChildProcess::wait() {
  auto exit = waitWith(0);
  for (; !exit; exit = waitWith(0)) {
  }
  return *exit;
}

std::optional<ChildExit> ChildProcess::waitWith(int options) {
  int status = 0;
  const pid_t ended = ::waitpid(pid_, &status, options);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return std::nullopt;
  pid_ = -1;
  if (WIFEXITED(status)) return ChildExit{WEXITSTATUS(status), 0};
  return ChildExit{-1, WTERMSIG(status)};
}

void ChildProcess::send(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);
}

}  // namespace dynemo
