// The same input gives the same bytes.
#include <gtest/gtest.h>

#include <map>

#include "slam_run.h"

namespace dynemo::test {
namespace {

/// The files that hold times.
const std::set<std::string> kTimed = {"timing.csv", "optimizations.csv", "performance.json"};

/// Content by path in the run's folder, without the files that hold times.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && !kTimed.contains(name)) files[name] = readBytes(entry.path());
  }
  return files;
}

void expectSameFiles(const fs::path& a, const fs::path& b) {
  const auto files_a = contents(a), files_b = contents(b);
  for (const char* name :
       {"trajectory.tum", "keyframes.tum", "odometry.tum", "entities.csv", "graph.g2o",
        "graph.graph", "scene.3Dscene", "map.png", "summary.json", "config.yaml", "log.txt",
        "loops.csv", "session/graph.bin", "session/clouds/000000.bin"}) {
    EXPECT_TRUE(files_a.contains(name)) << name;
  }
  for (const auto& [name, bytes] : files_a) {
    ASSERT_TRUE(files_b.contains(name)) << name;
    EXPECT_TRUE(bytes == files_b.at(name)) << name << " differs";
  }
  EXPECT_EQ(files_a.size(), files_b.size());
}

TEST(Determinism, TwoRunsGiveTheSameBytesFromWhereverTheyAreStarted) {
  const SlamRun& first = bundledRun("full");
  ASSERT_TRUE(first.ok());
  const TemporaryFolder folder;
  const Dataset d = bundledSample();
  const Outcome again = slam({"--setup", "full", "--entities", d.entities().filename(), "--output",
                              folder / "run", d.rawlog().filename()},
                             d.folder);
  ASSERT_EQ(again.status, 0) << describe(again);
  expectSameFiles(first.folder(), folder / "run");
}

TEST(Determinism, LidarOdometryGivesTheSameBytesWithAnyNumberOfThreads) {
  const TemporaryFolder folder;
  Dataset beginning = bundledSample();
  copyRawlog(beginning.rawlog(), folder / "beginning.rawlog", firstSeconds(6));
  fs::create_directory_symlink(beginning.images(), folder / "beginning_Images");
  for (const std::string threads : {"1", "3"}) {
    const Outcome run = slam({"--entities", beginning.entities(), "--output", folder / threads,
                              "--set", "odometry.source=lidar", "--set",
                              "odometry.lidar.threads=" + threads, folder / "beginning.rawlog"});
    ASSERT_EQ(run.status, 0) << describe(run);
    // The number of threads is part of the effective configuration.
    for (const char* name : {"config.yaml", "session/config.yaml"})
      fs::remove(folder / threads / name);
  }
  const auto one = contents(folder / "1"), three = contents(folder / "3");
  EXPECT_GT(one.size(), 8u);
  EXPECT_TRUE(one == three);
}

}  // namespace
}  // namespace dynemo::test
