// dynemo-ablation from datasets to report, and that its shortcuts change nothing.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

#include "slam_run.h"

namespace dynemo::test {
namespace {

Outcome ablation(const fs::path& output, const Arguments& more = {}) {
  Arguments command{
      DYNEMO_ABLATION, "--plan", "smoke",      "--datasets", "S-SAMO", "--setups", "baseline,full",
      "--seeds",       "1",      "--duration", "12",         "--jobs", "2",        "--output",
      output.string()};
  command.insert(command.end(), more.begin(), more.end());
  return runCommand(command);
}

TEST(Ablation, RunsReportsAndContinuesWhereItStopped) {
  const TemporaryFolder folder;
  const Outcome first = ablation(folder.path());
  ASSERT_EQ(first.status, 0) << describe(first);
  EXPECT_NE(first.out.find("[2/2] S-SAMO/seed1/keyframe_gicp/full"), std::string::npos)
      << first.out;
  const std::string report = readBytes(folder / "report.html");
  for (const char* part : {"<td>baseline</td>", "<td>Full</td>", "</svg>", "Missing"})
    EXPECT_EQ(report.find(part) != std::string::npos, std::string(part) != "Missing") << part;
  EXPECT_FALSE(fs::exists(folder / "datasets/S-SAMO_seed1/data.rawlog"))
      << "only truth and world are kept";

  // Nothing is left to do: the same report from the kept results.
  const Outcome second = ablation(folder.path());
  ASSERT_EQ(second.status, 0) << describe(second);
  EXPECT_EQ(second.out.find("["), std::string::npos) << second.out;
  EXPECT_EQ(readBytes(folder / "report.html"), report);

  // A lost result is made again, with the same accuracy.
  const std::string runs = readBytes(folder / "runs.csv");
  fs::remove(folder / "runs/S-SAMO/seed1/keyframe_gicp/full/result.json");
  const Outcome third = ablation(folder.path());
  ASSERT_EQ(third.status, 0) << describe(third);
  EXPECT_NE(third.out.find("[2/2]"), std::string::npos) << third.out;
  // Without the last line's two times.
  const auto accuracy = [](const std::string& csv) {
    return csv.substr(0, csv.rfind(',', csv.rfind(',') - 1));
  };
  EXPECT_EQ(accuracy(readBytes(folder / "runs.csv")), accuracy(runs));
}

/// Running programs that have both texts in their command line.
std::size_t processesNaming(const std::string& program, const std::string& text) {
  std::size_t count = 0;
  for (const auto& process : fs::directory_iterator("/proc")) {
    std::ifstream in(process.path() / "cmdline", std::ios::binary);
    const std::string line(std::istreambuf_iterator<char>(in), {});
    const bool both =
        line.find(program) != std::string::npos && line.find(text) != std::string::npos;
    count += both ? 1 : 0;
  }
  return count;
}

TEST(Ablation, NoProgramOutlivesIt) {
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    const TemporaryFolder folder;
    const std::string name = folder.path().string();
    const auto wait = [&](std::chrono::seconds limit_s, auto reached) {
      const auto limit = std::chrono::steady_clock::now() + limit_s;
      while (!reached() && std::chrono::steady_clock::now() < limit)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      return reached();
    };
    Process study({DYNEMO_ABLATION, "--plan", "smoke", "--duration", "60", "--output", name});
    ASSERT_TRUE(wait(kTimeLimit, [&] { return processesNaming("dynemo-simulate", name) == 1; }));
    study.send(signal);
    EXPECT_EQ(study.finish(kTimeLimit).signal, signal);
    EXPECT_TRUE(
        wait(std::chrono::seconds(2), [&] { return processesNaming("dynemo-", name) == 0; }));
  }
}

TEST(Ablation, UnknownDatasetsAndPlansAreRefused) {
  const TemporaryFolder folder;
  const Outcome dataset = runCommand({DYNEMO_ABLATION, "--plan", "smoke", "--datasets", "S-NONE",
                                      "--quiet", "--output", folder.path().string()});
  EXPECT_EQ(dataset.status, 3) << describe(dataset);
  EXPECT_NE(dataset.err.find("dynemo-simulate ended with status 2"), std::string::npos)
      << dataset.err;
  const Outcome plan =
      runCommand({DYNEMO_ABLATION, "--plan", "none", "--output", folder.path().string()});
  EXPECT_EQ(plan.status, 2) << describe(plan);
  EXPECT_EQ(plan.err.rfind("dynemo-ablation: none", 0), 0u) << plan.err;
}

TEST(FrontEndCache, GivesTheSameBytes) {
  const TemporaryFolder folder;
  const Dataset dataset = bundledSample();
  const fs::path shortened = folder / "short.rawlog";
  copyRawlog(dataset.rawlog(), shortened, firstSeconds(12.0));
  fs::create_directory_symlink(dataset.images(), folder / "short_Images");
  const auto run = [&](const std::string& name, const Arguments& more) {
    Arguments command{"--entities",
                      dataset.entities().string(),
                      "--set",
                      "odometry.source=lidar",
                      "--quiet",
                      "--output",
                      (folder / name).string(),
                      shortened.string()};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = slam(command);
    ASSERT_EQ(outcome.status, 0) << describe(outcome);
  };
  const std::string cache = (folder / "front_end.cache").string();
  run("without", {"--setup", "full"});
  run("recording", {"--setup", "baseline", "--front-end-cache", cache});
  ASSERT_TRUE(fs::exists(cache));
  ASSERT_FALSE(fs::is_empty(cache + ".planes"));
  run("replaying", {"--setup", "full", "--front-end-cache", cache});
  for (const char* file : {"trajectory.tum", "keyframes.tum", "odometry.tum", "entities.csv",
                           "graph.g2o", "summary.json"})
    EXPECT_EQ(readBytes(folder / "replaying" / file), readBytes(folder / "without" / file)) << file;

  // Other parameters of the front-end: recorded anew, not replayed.
  run("other", {"--setup", "full", "--front-end-cache", cache, "--set",
                "perception.tag_pose.corner_sigma_base_px=0.5"});
  EXPECT_NE(readBytes(folder / "other" / "entities.csv"),
            readBytes(folder / "without" / "entities.csv"));
}

}  // namespace
}  // namespace dynemo::test
