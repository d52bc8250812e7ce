// Outputs that cannot be written, and runs that are interrupted.
#include <gtest/gtest.h>

#include <csignal>

#include "dynemo/evaluation/entity_data.h"
#include "dynemo/evaluation/trajectory.h"
#include "dynemo/graph/session.h"
#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr int kData = 3;
constexpr int kInterrupted = 130;
constexpr std::size_t kFrames = 131;

class Output : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    cut_ = new TemporaryFolder;
    copyRawlog(bundledSample().rawlog(), *cut_ / "cut.rawlog", firstSeconds(3));
    fs::create_directory_symlink(bundledSample().images(), *cut_ / "cut_Images");
    fs::create_symlink(bundledSample().entities(), *cut_ / "cut_entities.yaml");
  }
  static void TearDownTestSuite() {
    delete cut_;
    cut_ = nullptr;
  }
  static Dataset beginning() { return {cut_->path(), "cut"}; }
  void expectNoPartialFiles() const {
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }

  static inline TemporaryFolder* cut_ = nullptr;
  TemporaryFolder folder_;
};

TEST_F(Output, AFileInTheWayOfTheFolder) {
  writeBytes(folder_ / "run", "mine");
  expectRefusal(slam(slamCommand(beginning(), folder_ / "run")), kData, {folder_ / "run"});
  expectRefusal(slam(slamCommand(beginning(), folder_ / "run" / "deeper")), kData,
                {folder_ / "run"});
  EXPECT_EQ(readBytes(folder_ / "run"), "mine");
}

TEST_F(Output, AFolderInTheWayOfALog) {
  fs::create_directories(folder_ / "run" / "log.txt");
  expectRefusal(slam(slamCommand(beginning(), folder_ / "run")), kData, {"log.txt"});
}

TEST_F(Output, EveryFileIsTriedAndAllFailuresAreListed) {
  fs::create_directories(folder_ / "run" / "keyframes.tum" / "x");
  fs::create_directories(folder_ / "run" / "summary.json" / "x");
  writeBytes(folder_ / "run" / "session", "mine");
  expectRefusal(slam(slamCommand(beginning(), folder_ / "run", {"-q"})), kData,
                {"keyframes.tum", "summary.json", "session"});
  EXPECT_GT(readTum(folder_ / "run" / "trajectory.tum").size(), 0u);
  EXPECT_FALSE(readEntityEstimates(folder_ / "run" / "entities.csv").empty());
  expectNoPartialFiles();
}

/// A run whose files cannot grow beyond so many kibibytes, as on a full disk.
Outcome limitedRun(const fs::path& output, const std::string& kibibytes) {
  const std::string script =
      "ulimit -f $((2 * " + kibibytes + ")); trap '' XFSZ; exec \"$0\" \"$@\"";
  Arguments command = {"sh", "-c", script, DYNEMO_SLAM};
  for (const std::string& argument : slamCommand(bundledSample(), output, {"-q"}))
    command.push_back(argument);
  return runCommand(command);
}

TEST_F(Output, ADiskThatIsFullAtTheEndKeepsWhatIsComplete) {
  expectRefusal(limitedRun(folder_ / "run", "50"), kData,
                {"entities.csv", "graph.g2o", "scene.3Dscene", "session"});
  EXPECT_EQ(readTum(folder_ / "run" / "trajectory.tum").size(), kFrames);
  EXPECT_EQ(readJson(folder_ / "run" / "summary.json").at("frames"), kFrames);
  for (const char* name : {"entities.csv", "graph.g2o", "scene.3Dscene"})
    EXPECT_FALSE(fs::exists(folder_ / "run" / name)) << name;
  expectNoPartialFiles();
}

TEST_F(Output, ADiskThatIsFullFromTheBeginning) {
  expectRefusal(limitedRun(folder_ / "run", "1"), kData, {"config.yaml", "disk full"});
  expectNoPartialFiles();
}

TEST_F(Output, AnInterruptedRunLeavesTheResultsOfWhatItProcessed) {
  Process program = [&] {
    Arguments command = {DYNEMO_SLAM};
    // LiDAR odometry takes its time.
    for (const auto& a :
         slamCommand(bundledSample(), folder_ / "run", {"-v", "--set", "odometry.source=lidar"}))
      command.push_back(a);
    return Process(command);
  }();
  ASSERT_TRUE(program.waitForError("keyframe 3 at", kTimeLimit));
  program.send(SIGINT);
  const Outcome outcome = program.finish(kTimeLimit);
  ASSERT_EQ(outcome.status, kInterrupted) << describe(outcome);

  const fs::path run = folder_ / "run";
  const std::size_t frames = readTum(run / "trajectory.tum").size();
  EXPECT_GE(frames, 3u);
  EXPECT_LT(frames, kFrames);
  EXPECT_EQ(readJson(run / "summary.json").at("frames"), frames);
  const Session session = loadSession(run / "session");
  EXPECT_EQ(session.graph.keyframes().size(), readTum(run / "keyframes.tum").size());
  EXPECT_GE(session.graph.keyframes().size(), 3u);
  EXPECT_FALSE(readEntityEstimates(run / "entities.csv").empty());
  EXPECT_TRUE(fs::exists(run / "scene.3Dscene"));
  expectNoPartialFiles();
}

TEST_F(Output, AKilledRunLeavesItsLastCheckpoint) {
  Arguments command = {DYNEMO_SLAM};
  for (const auto& a :
       slamCommand(bundledSample(), folder_ / "run",
                   {"-v", "--set", "checkpoint_s=1", "--set", "odometry.source=lidar"}))
    command.push_back(a);
  Process program(command);
  ASSERT_TRUE(program.waitForError("keyframe 8 at", kTimeLimit));
  program.send(SIGKILL);
  const Outcome outcome = program.finish(kTimeLimit);
  ASSERT_EQ(outcome.signal, SIGKILL) << describe(outcome);

  const fs::path run = folder_ / "run";
  const std::size_t frames = readTum(run / "trajectory.tum").size();
  EXPECT_GE(frames, 3u);
  EXPECT_LT(frames, kFrames);
  EXPECT_FALSE(readEntityEstimates(run / "entities.csv").empty());
  EXPECT_FALSE(readJson(run / "summary.json").at("entities").empty());
  EXPECT_NE(readBytes(run / "log.txt").find("keyframe 7 at"), std::string::npos);
}

}  // namespace
}  // namespace dynemo::test
