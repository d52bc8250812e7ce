#include "dynemo/core/child_process.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kLimit = 20s;

fs::path output(const std::string& name) { return fs::path(testing::TempDir()) / name; }

std::string firstLine(const fs::path& file) {
  std::string line;
  std::ifstream in(file);
  std::getline(in, line);
  return line;
}

template <class Condition>
bool comesTrue(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + kLimit;
  while (!condition() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(5ms);
  return condition();
}

TEST(ChildProcess, GivesTheStatusAndTheOutput) {
  const ChildExit exit = ChildProcess({"sh", "-c", "echo said; exit 7"}, output("said")).wait();
  EXPECT_EQ(exit.status, 7);
  EXPECT_EQ(exit.signal, 0);
  EXPECT_EQ(firstLine(output("said")), "said");
}

TEST(ChildProcess, TellsWhichSignalEndedIt) {
  const ChildExit exit = ChildProcess({"sh", "-c", "kill -9 $$"}, output("killed")).wait();
  EXPECT_EQ(exit.status, -1);
  EXPECT_EQ(exit.signal, SIGKILL);
}

TEST(ChildProcess, AProgramThatIsNotThereSaysSo) {
  EXPECT_EQ(ChildProcess({"/nonexistent/program"}, output("missing")).wait().status, 127);
  EXPECT_NE(firstLine(output("missing")).find("cannot be started"), std::string::npos);
  EXPECT_THROW(ChildProcess({"true"}, "/nonexistent/output"), DataError);
}

TEST(ChildProcess, IsEndedWithItsOwner) {
  pid_t pid = 0;
  {
    ChildProcess child({"sh", "-c", "echo $$; exec sleep 600"}, output("owned"));
    ASSERT_TRUE(comesTrue([] { return !firstLine(output("owned")).empty(); }));
    pid = std::stoi(firstLine(output("owned")));
    EXPECT_EQ(child.poll(), std::nullopt);
    EXPECT_EQ(::kill(pid, 0), 0);
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

/// Whatever ends the waiting program: it may get no chance to do anything about it.
class ChildOutlives : public testing::TestWithParam<int> {};

TEST_P(ChildOutlives, NoSignalToItsParent) {
  const fs::path file = output("orphan" + std::to_string(GetParam()));
  fs::remove(file);
  const pid_t parent = ::fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {
    ::signal(GetParam(), SIG_DFL);
    ChildProcess({"sh", "-c", "echo $$; exec sleep 600"}, file).wait();
    ::_exit(0);
  }
  ASSERT_TRUE(comesTrue([&] { return !firstLine(file).empty(); }));
  const pid_t child = std::stoi(firstLine(file));
  ASSERT_EQ(::kill(child, 0), 0);
  ::kill(parent, GetParam());
  int status = 0;
  ASSERT_EQ(::waitpid(parent, &status, 0), parent);
  EXPECT_EQ(WTERMSIG(status), GetParam());
  // Dead, or a zombie where the first process of the system does not reap.
  EXPECT_TRUE(comesTrue([&] {
    std::ifstream stat("/proc/" + std::to_string(child) + "/stat");
    std::string id, name, state;
    return !(stat >> id >> name >> state) || state == "Z";
  }));
}

INSTANTIATE_TEST_SUITE_P(Signals, ChildOutlives, testing::Values(SIGINT, SIGTERM, SIGKILL),
                         [](const auto& test) { return "Signal" + std::to_string(test.param); });

}  // namespace
}  // namespace dynemo
