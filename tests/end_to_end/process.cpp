#include "process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <system_error>

namespace dynemo::test {

namespace {

void require(bool ok, const char* what) {
  if (!ok) throw std::system_error(errno, std::generic_category(), what);
}

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    require(::pipe2(ends.data(), O_CLOEXEC) == 0, "pipe2");
    read = ends[0];
    write = ends[1];
  }
  int read = -1, write = -1;
};

/// What posix_spawn does in the child before it runs the program.
class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  posix_spawn_file_actions_t* get() { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

int millisecondsUntil(std::chrono::steady_clock::time_point deadline) {
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
  return left.count() > 0 ? static_cast<int>(left.count()) : 0;
}

/// Appends what can be read without waiting; closes the pipe at its end.
void drain(int& pipe, std::string& text) {
  std::array<char, 4096> buffer{};
  const ssize_t n = ::read(pipe, buffer.data(), buffer.size());
  if (n > 0) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  } else if (n == 0 || errno != EINTR) {
    ::close(pipe);
    pipe = -1;
  }
}

}  // namespace

std::string describe(const Outcome& o) {
  return "status " + std::to_string(o.status) + ", signal " + std::to_string(o.signal) +
         (o.timed_out ? ", timed out" : "") + "\nstdout:\n" + o.out + "\nstderr:\n" + o.err;
}

Process::Process(std::vector<std::string> command, const std::filesystem::path& working_folder) {
  const Pipe out, err;
  out_ = out.read;
  err_ = err.read;
  FileActions actions;
  posix_spawn_file_actions_addopen(actions.get(), STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(actions.get(), out.write, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(actions.get(), err.write, STDERR_FILENO);
  if (!working_folder.empty())
    posix_spawn_file_actions_addchdir_np(actions.get(), working_folder.c_str());
  std::vector<char*> arguments;
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int failure =
      posix_spawnp(&pid_, arguments[0], actions.get(), nullptr, arguments.data(), environ);
  ::close(out.write);
  ::close(err.write);
  if (failure != 0) {
    pid_ = -1;
    throw std::system_error(failure, std::generic_category(), command[0]);
  }
}

Process::~Process() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  for (const int pipe : {out_, err_}) {
    if (pipe >= 0) ::close(pipe);
  }
}

bool Process::pump(Clock::time_point deadline) {
  if (out_ < 0 && err_ < 0) return false;
  std::array<pollfd, 2> pipes = {pollfd{out_, POLLIN, 0}, pollfd{err_, POLLIN, 0}};
  const int ready = ::poll(pipes.data(), pipes.size(), millisecondsUntil(deadline));
  if (ready <= 0) return ready < 0 && errno == EINTR;
  if (pipes[0].revents != 0) drain(out_, outcome_.out);
  if (pipes[1].revents != 0) drain(err_, outcome_.err);
  return true;
}

bool Process::waitForError(const std::string& text, std::chrono::seconds limit) {
  const auto deadline = Clock::now() + limit;
  while (outcome_.err.find(text) == std::string::npos) {
    if (!pump(deadline)) return false;
  }
  return true;
}

void Process::send(int signal) const { ::kill(pid_, signal); }

bool Process::waitForExit(Clock::time_point deadline) const {
  // glibc 2.36 declares pidfd_open without C linkage.
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0));
  require(handle >= 0, "pidfd_open");
  pollfd end{handle, POLLIN, 0};
  const int ready = ::poll(&end, 1, millisecondsUntil(deadline));
  ::close(handle);
  return ready == 1;
}

Outcome Process::finish(std::chrono::seconds limit) {
  const auto deadline = Clock::now() + limit;
  while (pump(deadline)) {
  }
  outcome_.timed_out = !waitForExit(deadline);
  if (outcome_.timed_out) send(SIGKILL);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
  if (WIFEXITED(status)) outcome_.status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome_.signal = WTERMSIG(status);
  return outcome_;
}

Outcome runCommand(const std::vector<std::string>& command,
                   const std::filesystem::path& working_folder, std::chrono::seconds limit) {
  return Process(command, working_folder).finish(limit);
}

}  // namespace dynemo::test
