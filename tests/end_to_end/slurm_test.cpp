// dynemo-batch --slurm against Debian's Slurm, whose daemons the test starts on this machine with a
// configuration of its own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <thread>

#include "dataset.h"
#include "process.h"

namespace dynemo::test {
namespace {

std::string programPath(const std::string& name) {
  const Outcome found = runCommand({"sh", "-c", "PATH=$PATH:/usr/sbin:/sbin command -v " + name});
  return found.out.substr(0, found.out.find('\n'));
}

/// munged, slurmctld and slurmd in a folder of their own.
class Cluster {
 public:
  explicit Cluster(const fs::path& folder) : folder_(folder) {
    writeConfiguration();
    daemons_.push_back(std::make_unique<Process>(std::vector<std::string>{
        programPath("munged"), "--foreground", "--force", "--socket=" + file("munge.socket"),
        "--key-file=" + file("munge.key"), "--log-file=" + file("munged.log"),
        "--pid-file=" + file("munged.pid"), "--seed-file=" + file("munged.seed")}));
    waitFor([&] { return fs::exists(file("munge.socket")); });
    ::setenv("SLURM_CONF", file("slurm.conf").c_str(), 1);
    daemons_.push_back(
        std::make_unique<Process>(std::vector<std::string>{programPath("slurmctld"), "-D", "-i"}));
    daemons_.push_back(std::make_unique<Process>(
        std::vector<std::string>{programPath("slurmd"), "-D", "-N", "localhost"}));
    ready_ = waitFor([] {
      const Outcome nodes = runCommand({"sinfo", "--noheader", "--format=%T"});
      return nodes.status == 0 && nodes.out.find("idle") != std::string::npos;
    });
  }
  ~Cluster() {
    for (auto it = daemons_.rbegin(); it != daemons_.rend(); ++it) {
      (*it)->send(SIGTERM);
      (*it)->finish(std::chrono::seconds(20));
    }
    ::unsetenv("SLURM_CONF");
  }
  bool ready() const { return ready_; }
  std::string log() const {
    return readBytes(file("slurmctld.log")) + "\n" + readBytes(file("slurmd.log"));
  }

 private:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  static bool waitFor(const std::function<bool()>& condition) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > limit) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
  }

  void writeConfiguration() {
    fs::create_directories(folder_ / "state");
    fs::create_directories(folder_ / "spool");
    std::random_device random;
    std::string key;
    for (int i = 0; i < 1024; ++i) key += static_cast<char>(random());
    writeBytes(folder_ / "munge.key", key);
    fs::permissions(folder_ / "munge.key", fs::perms::owner_read);
    writeBytes(folder_ / "slurmctld.log", "");
    writeBytes(folder_ / "slurmd.log", "");
    const Outcome user = runCommand({"id", "-un"});
    const std::string name = user.out.substr(0, user.out.find('\n'));
    // Ports that a second test run at the same time does not use.
    const int port = 20000 + static_cast<int>(::getpid() % 10000) * 2;
    std::ofstream conf(folder_ / "slurm.conf");
    conf << "ClusterName=test\nSlurmctldHost=localhost\nSlurmUser=" << name
         << "\nSlurmdUser=" << name
         << "\nAuthType=auth/munge\nAuthInfo=socket=" << file("munge.socket")
         << "\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nMpiDefault=none\n"
            "ReturnToService=2\nSwitchType=switch/none\nSelectType=select/cons_tres\n"
            "SelectTypeParameters=CR_Core\nJobAcctGatherType=jobacct_gather/none\n"
            "AccountingStorageType=accounting_storage/none\nMinJobAge=30\n"
            "SchedulerParameters=sched_interval=1,bf_interval=1\n"
         << "SlurmctldPidFile=" << file("slurmctld.pid") << "\nSlurmdPidFile=" << file("slurmd.pid")
         << "\nSlurmctldPort=" << port << "\nSlurmdPort=" << port + 1
         << "\nSlurmdSpoolDir=" << file("spool") << "\nStateSaveLocation=" << file("state")
         << "\nSlurmctldLogFile=" << file("slurmctld.log")
         << "\nSlurmdLogFile=" << file("slurmd.log")
         << "\nNodeName=localhost CPUs=2 State=UNKNOWN\n"
            "PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n";
  }

  fs::path folder_;
  std::vector<std::unique_ptr<Process>> daemons_;
  bool ready_ = false;
};

class Slurm : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo"})
      if (programPath(program).empty()) GTEST_SKIP() << program << " is not installed";
    cluster = std::make_unique<Cluster>(folder.path());
    if (!cluster->ready()) GTEST_SKIP() << "Slurm does not start here:\n" << cluster->log();
    for (const char* name : {"first", "second", "broken"}) {
      if (name == std::string("broken")) {
        writeBytes(path("broken.rawlog"), "no rawlog");
        continue;
      }
      ASSERT_EQ(runCommand({DYNEMO_PREP, "trim", bundledSample().rawlog().string(), "--to", "5",
                            "-o", path(std::string(name) + ".rawlog")})
                    .status,
                0);
    }
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  TemporaryFolder folder;
  std::unique_ptr<Cluster> cluster;
};

TEST_F(Slurm, RunsTheWorkListAsAJobArrayAndCollects) {
  const std::vector<std::string> local = {
      DYNEMO_BATCH, path("first.rawlog"),  path("second.rawlog"), "--work", path("local"),
      "--set",      "outputs=[trajectory]"};
  ASSERT_EQ(runCommand(local).status, 0);

  std::vector<std::string> remote = local;
  remote[4] = path("cluster");
  remote.insert(remote.end(), {path("broken.rawlog"), "--slurm", "--slurm-option=--time=10"});
  const Outcome batch = runCommand(remote);
  EXPECT_EQ(batch.status, 1) << describe(batch) << cluster->log();
  EXPECT_NE(batch.out.find("with 3 tasks"), std::string::npos) << batch.out;
  EXPECT_NE(batch.err.find("failed      broken/default: exit status 3"), std::string::npos)
      << describe(batch) << cluster->log();
  for (const char* name : {"first/default/trajectory.tum", "second/default/trajectory.tum"})
    EXPECT_EQ(readBytes(folder / "cluster" / name), readBytes(folder / "local" / name)) << name;
  const std::string summary = readBytes(folder / "cluster" / "summary.csv");
  EXPECT_NE(summary.find("second,default,done,"), std::string::npos) << summary;
  EXPECT_NE(summary.find("broken,default,failed,"), std::string::npos) << summary;

  // A second call submits what is missing only.
  const Outcome again = runCommand(remote);
  EXPECT_NE(again.out.find("with 1 tasks"), std::string::npos) << describe(again);
}

TEST_F(Slurm, SubmitsWithoutWaitingAndCollectsLater) {
  const std::vector<std::string> common = {
      DYNEMO_BATCH, path("first.rawlog"), "--work", path("work"), "--set", "outputs=[trajectory]"};
  auto submit = common, collect = common;
  submit.insert(submit.end(), {"--slurm", "--no-wait"});
  collect.emplace_back("--collect");
  ASSERT_EQ(runCommand(submit).status, 0);
  const auto limit = std::chrono::steady_clock::now() + kTimeLimit;
  while (runCommand(collect).status != 0 && std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(runCommand(collect).status, 0) << cluster->log();
}

TEST_F(Slurm, ARefusalIsOneError) {
  const Outcome refused = runCommand({DYNEMO_BATCH, path("first.rawlog"), "--work", path("work"),
                                      "--slurm", "--slurm-option=--partition=nowhere"});
  EXPECT_EQ(refused.status, 3);
  EXPECT_NE(refused.err.find("sbatch refuses the job: "), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("nowhere"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.err.find("error: "), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace dynemo::test
