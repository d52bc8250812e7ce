// Layers of configuration and the file that lists the defaults.
#include <gtest/gtest.h>

#include "slam_run.h"

namespace dynemo::test {
namespace {

std::string dump(const Arguments& arguments = {}) {
  Arguments all = arguments;
  all.push_back("--dump-config");
  const Outcome outcome = slam(all);
  EXPECT_EQ(outcome.status, 0) << describe(outcome);
  EXPECT_TRUE(outcome.err.empty()) << outcome.err;
  return outcome.out;
}

/// Value of robot_translation_m, the only key of that name.
std::string robotTranslation(const std::string& yaml) {
  const std::string key = "robot_translation_m: ";
  const auto at = yaml.find(key) + key.size();
  return yaml.substr(at, yaml.find('\n', at) - at);
}

TEST(Configuration, DefaultFileListsTheDefaults) {
  EXPECT_TRUE(dump() == readBytes(fs::path(DYNEMO_SOURCE_DIR) / "config" / "default.yaml"))
      << "config/default.yaml does not list the built-in defaults. When they were meant to change: "
         "dynemo-slam --dump-config > config/default.yaml";
}

TEST(Configuration, ADumpReadBackIsTheSame) {
  const TemporaryFolder folder;
  const auto read_back = [&](const std::string& yaml) {
    writeBytes(folder / "dump.yaml", yaml);
    return dump({"--config", folder / "dump.yaml"});
  };
  const std::string defaults = dump();
  EXPECT_EQ(read_back(defaults), defaults);
  for (const char* setup :
       {"always-epcr", "baseline", "f-e", "fcs", "full", "intra-e", "mb-epcr", "only-kf-e"}) {
    const std::string yaml = dump({"--setup", setup});
    EXPECT_EQ(read_back(yaml), yaml) << setup;
  }
  const std::string changed =
      dump({"--set", "sensors.extrinsics={cam era: [1,2,3,0,0,0,1]}", "--set", "outputs=[entities]",
            "--set", "keyframes.robot_rotation_deg=12.3456789"});
  EXPECT_NE(changed, defaults);
  EXPECT_EQ(read_back(changed), changed);
}

TEST(Configuration, TheRunFolderHoldsTheEffectiveOne) {
  const SlamRun& run = bundledRun("baseline");
  EXPECT_EQ(readBytes(run.folder() / "config.yaml"), dump({"--setup", "baseline"}));
  EXPECT_EQ(readBytes(run.folder() / "session" / "config.yaml"), dump({"--setup", "baseline"}));
}

TEST(Configuration, LaterLayersWin) {
  const TemporaryFolder folder;
  const std::string file = folder / "mine.yaml";
  writeBytes(file, "keyframes:\n  robot_translation_m: 1.5\n");
  const std::string from_default = robotTranslation(dump());
  EXPECT_NE(from_default, "2");
  EXPECT_EQ(robotTranslation(dump({"--setup", "baseline"})), "2");
  // The order on the command line does not matter.
  EXPECT_EQ(robotTranslation(dump({"--config", file, "--setup", "baseline"})), "1.5");
  EXPECT_EQ(robotTranslation(dump({"--set", "keyframes.robot_translation_m=1.25", "--config", file,
                                   "--setup", "baseline"})),
            "1.25");
  EXPECT_EQ(robotTranslation(dump({"--set", "keyframes.robot_translation_m=1.25", "--set",
                                   "keyframes.robot_translation_m=1.75"})),
            "1.75");
  EXPECT_NE(dump({"--config", file, "--setup", "baseline"}).find("mode: baseline"),
            std::string::npos)
      << "what a layer does not name stays";
}

TEST(Configuration, OnlyTheConfiguredOutputsAreWritten) {
  const TemporaryFolder folder;
  const Dataset d = bundledSample();
  copyRawlog(d.rawlog(), folder / "short.rawlog", firstSeconds(2));
  const Outcome run =
      slam({"--set", "outputs=[keyframes]", "--output", folder / "run", folder / "short.rawlog"});
  ASSERT_EQ(run.status, 0) << describe(run);
  EXPECT_TRUE(fs::exists(folder / "run" / "keyframes.tum"));
  for (const char* name :
       {"trajectory.tum", "entities.csv", "graph.g2o", "scene.3Dscene", "session"})
    EXPECT_FALSE(fs::exists(folder / "run" / name)) << name;
}

}  // namespace
}  // namespace dynemo::test
