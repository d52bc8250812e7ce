// dynemo-batch with the real dynemo-slam: killed and continued, with failures, with ground truth.
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <sstream>
#include <thread>

#include "dataset.h"
#include "process.h"

namespace dynemo::test {
namespace {

constexpr std::size_t kRuns = 8;

/// Files of a work folder with their contents, but for what holds times.
std::map<std::string, std::string> contents(const fs::path& work) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(work)) {
    const std::string name = fs::relative(entry.path(), work).string();
    const std::string file = entry.path().filename().string();
    const bool times = file == "timing.csv" || file == "optimizations.csv" ||
                       file == "performance.json" || file == "performance.csv";
    if (!entry.is_regular_file() || times || name.starts_with(".")) continue;
    files[name] = readBytes(entry.path());
  }
  return files;
}

std::size_t finishedRuns(const fs::path& work) {
  std::size_t count = 0;
  std::error_code ignored;
  for (const auto& log : fs::directory_iterator(work, ignored))
    for (const auto& run : fs::directory_iterator(log.path(), ignored))
      count += log.path().filename() != ".runs" && fs::exists(run.path() / "arguments.txt") ? 1 : 0;
  return count;
}

class BatchProgram : public ::testing::Test {
 protected:
  /// Two short logs times four setups.
  void SetUp() override {
    for (const char* name : {"first", "second"}) {
      const double from_s = name == std::string("first") ? 0.0 : 20.0;
      const Outcome cut = runCommand({DYNEMO_PREP, "trim", sample.rawlog().string(), "--from",
                                      std::to_string(from_s), "--to", std::to_string(from_s + 12.0),
                                      "-o", path(std::string(name) + ".rawlog")});
      ASSERT_EQ(cut.status, 0) << describe(cut);
      fs::copy(sample.entities(), path(std::string(name) + "_entities.yaml"));
      fs::copy(sample.truth(), path(std::string(name) + "_gt_robot.tum"));
    }
  }
  std::vector<std::string> command(const std::string& work) const {
    return {DYNEMO_BATCH, path("*.rawlog"),
            "--work",     work,
            "--jobs",     "2",
            "--setup",    "baseline",
            "--setup",    "full",
            "--setup",    "fcs",
            "--setup",    "only-kf-e",
            "--set",      "outputs=[trajectory,keyframes,odometry,entities,g2o]"};
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  const Dataset sample = bundledSample();
  TemporaryFolder folder;
};

TEST_F(BatchProgram, KilledAndContinuedGivesTheFilesOfAnUndisturbedOne) {
  const Outcome undisturbed = runCommand(command(path("undisturbed")));
  ASSERT_EQ(undisturbed.status, 0) << describe(undisturbed);
  ASSERT_EQ(finishedRuns(path("undisturbed")), kRuns);
  EXPECT_NE(undisturbed.out.find("ate_m"), std::string::npos);

  {
    Process batch(command(path("killed")));
    const auto limit = std::chrono::steady_clock::now() + kTimeLimit;
    while (finishedRuns(path("killed")) < kRuns / 2 && std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    batch.send(SIGKILL);
    EXPECT_EQ(batch.finish(kTimeLimit).signal, SIGKILL);
  }
  const std::size_t before = finishedRuns(path("killed"));
  EXPECT_GE(before, kRuns / 2);
  EXPECT_LT(before, kRuns) << "the batch was too fast to be killed half-way";
  const Outcome continued = runCommand(command(path("killed")));
  ASSERT_EQ(continued.status, 0) << describe(continued);
  const auto expected = contents(path("undisturbed")), found = contents(path("killed"));
  EXPECT_EQ(expected.size(), found.size());
  for (const auto& [name, bytes] : expected) {
    ASSERT_TRUE(found.contains(name)) << name;
    EXPECT_TRUE(found.at(name) == bytes) << name << " differs";
  }
}

TEST_F(BatchProgram, AFailedRunIsReportedAndTheRestFinished) {
  writeBytes(path("broken.rawlog"), "no rawlog");
  fs::copy(sample.entityTruth(), path("first_gt_entities.csv"));
  const Outcome batch = runCommand({DYNEMO_BATCH, path("broken.rawlog"), path("first.rawlog"),
                                    "--work", path("work"), "--set", "outputs=[trajectory]"});
  EXPECT_EQ(batch.status, 1) << describe(batch);
  EXPECT_NE(batch.err.find("failed      broken/default: exit status 3"), std::string::npos)
      << batch.err;
  EXPECT_NE(batch.err.find("done        first/default"), std::string::npos);
  const std::string summary = readBytes(path("work/summary.csv"));
  EXPECT_NE(summary.find("broken,default,failed"), std::string::npos) << summary;
  EXPECT_NE(summary.find("first,default,done,"), std::string::npos) << summary;
  EXPECT_EQ(summary.find("not evaluated"), std::string::npos) << summary;
}

TEST_F(BatchProgram, AWrongConfigurationIsRefusedBeforeAnythingRuns) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--setup", "nope"},
                                                {"--set", "keyframes.nope=1"},
                                                {"--config", path("nope.yaml")},
                                                {"--entities", path("nope.yaml")}}) {
    std::vector<std::string> command = {
        DYNEMO_BATCH, path("first.rawlog"), "--work", path("w"), "--setup", "full"};
    command.insert(command.end(), wrong.begin(), wrong.end());
    const Outcome refused = runCommand(command);
    EXPECT_EQ(refused.status, 2) << describe(refused);
    EXPECT_NE(refused.err.find("nope"), std::string::npos) << describe(refused);
    EXPECT_FALSE(fs::exists(path("w"))) << describe(refused);
  }
}

TEST_F(BatchProgram, RunsWithoutAnEntityFileAreWarnedOf) {
  ASSERT_EQ(
      runCommand({DYNEMO_PREP, "annotate", path("first.rawlog"), "--entities",
                  path("first_entities.yaml"), "--drop-images", "-o", path("annotated.rawlog")})
          .status,
      0);
  const Outcome batch = runCommand({DYNEMO_BATCH, path("annotated.rawlog"), path("first.rawlog"),
                                    "--work", path("w"), "--set", "outputs=[trajectory]"});
  EXPECT_EQ(batch.status, 0) << describe(batch);
  EXPECT_NE(batch.err.find("no entity file NAME_entities.yaml beside annotated.rawlog and no"),
            std::string::npos)
      << batch.err;
  EXPECT_NE(batch.out.find("detections were left out: without --entities"), std::string::npos)
      << batch.out;
}

TEST_F(BatchProgram, UsageErrors) {
  EXPECT_EQ(runCommand({DYNEMO_BATCH}).status, 2);
  EXPECT_EQ(runCommand({DYNEMO_BATCH, "--work", path("w")}).status, 2);
  EXPECT_EQ(runCommand({DYNEMO_BATCH, "--work", path("w"), path("nope*.rawlog")}).status, 3);
  EXPECT_EQ(
      runCommand({DYNEMO_BATCH, "--work", path("w"), path("first.rawlog"), "--no-wait"}).status, 2);
  EXPECT_EQ(runCommand({DYNEMO_BATCH, "--help"}).status, 0);
  const Outcome dry =
      runCommand({DYNEMO_BATCH, "--work", path("w"), path("*.rawlog"), "--dry-run"});
  EXPECT_EQ(dry.status, 0);
  EXPECT_NE(dry.out.find("missing  second/default  dynemo-slam"), std::string::npos) << dry.out;
}

}  // namespace
}  // namespace dynemo::test
