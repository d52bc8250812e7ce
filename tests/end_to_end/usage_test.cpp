// The command line: help, and one message for each way to get it wrong.
#include <gtest/gtest.h>

#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr int kUsage = 2;

/// A rawlog and output that a run gets as far as opening only when the command line is accepted.
Arguments with(const Arguments& arguments) {
  Arguments all = {"--output", "/nonexistent/folder", "/nonexistent/some.rawlog"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return all;
}

TEST(Usage, HelpAndVersionSucceed) {
  const Outcome help = slam({"--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* option : {"RAWLOG", "--config", "--setup", "--entities", "--detections", "--set",
                             "--output", "--dump-config", "--verbose", "--quiet", "--version"})
    EXPECT_NE(help.out.find(option), std::string::npos) << option;
  const Outcome version = slam({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_EQ(version.out, "dynemo-slam " DYNEMO_VERSION "\n");
  EXPECT_EQ(runCommand({DYNEMO_EVAL, "--help"}).status, 0);
  EXPECT_EQ(runCommand({DYNEMO_EVAL, "--version"}).out, "dynemo-eval " DYNEMO_VERSION "\n");
}

TEST(Usage, MissingArguments) {
  expectRefusal(slam({}), kUsage, {"RAWLOG"});
  expectRefusal(slam({"--output", "/nonexistent/folder"}), kUsage, {"RAWLOG"});
  expectRefusal(slam({"some.rawlog"}), kUsage, {"--output"});
  expectRefusal(slam(with({"--set"})), kUsage, {"--set"});
}

TEST(Usage, UnknownOptionsAndSurplusArguments) {
  expectRefusal(slam(with({"--nope"})), kUsage, {"--nope"});
  expectRefusal(slam(with({"--quite"})), kUsage, {"--quite", "did you mean --quiet?"});
  expectRefusal(slam(with({"second.rawlog"})), kUsage, {"second.rawlog"});
  expectRefusal(slam(with({"-v", "-q"})), kUsage, {"--verbose", "--quiet"});
}

TEST(Usage, AnUnknownSetupIsAnsweredWithTheKnownOnes) {
  expectRefusal(slam(with({"--setup", "nope"})), kUsage, {"nope", "baseline", "full"});
}

TEST(Usage, SetNeedsAKeyAndAValue) {
  expectRefusal(slam(with({"--set", "keyframes.timer"})), kUsage, {"keyframes.timer", "KEY=VALUE"});
  expectRefusal(slam(with({"--set", "=1"})), kUsage, {"=1", "KEY=VALUE"});
  expectRefusal(slam(with({"--set", "outputs=[a"})), kUsage, {"outputs=[a"});
}

TEST(Usage, WrongKeysAndValuesNameKeyValueAndConstraint) {
  expectRefusal(slam(with({"--set", "keyframes.nope=1"})), kUsage,
                {"keyframes.nope", "unknown key"});
  expectRefusal(slam(with({"--set", "keyframes=3"})), kUsage, {"keyframes", "3", "section"});
  expectRefusal(slam(with({"--set", "keyframes.timer=maybe"})), kUsage,
                {"keyframes.timer", "maybe", "true or false"});
  expectRefusal(slam(with({"--set", "keyframes.robot_translation_m=-1"})), kUsage,
                {"keyframes.robot_translation_m", "-1", "> 0"});
  expectRefusal(slam(with({"--set", "keyframes.robot_translation_m=.nan"})), kUsage,
                {"keyframes.robot_translation_m", "number"});
  expectRefusal(slam(with({"--set", "odometry.source=wheel"})), kUsage,
                {"odometry.source", "wheel", "auto, rawlog, lidar"});
}

TEST(Usage, AllWrongKeysAreReportedAtOnce) {
  const TemporaryFolder folder;
  writeBytes(folder / "wrong.yaml", "keyframes:\n  robot_translation_m: much\nnonsense: 1\n");
  expectRefusal(slam(with({"--config", folder / "wrong.yaml", "--set", "solver.nope=3", "--set",
                           "loops.enabled=7"})),
                kUsage,
                {"4 problems", "wrong.yaml: keyframes.robot_translation_m: much",
                 "wrong.yaml: nonsense", "--set: solver.nope", "--set: loops.enabled: 7"});
}

TEST(Usage, NamesThatNoRegistryKnowsAreAnsweredWithTheKnownOnes) {
  const Dataset d = bundledSample();
  const TemporaryFolder folder;
  const auto set = [&](const std::string& value) {
    return slam(slamCommand(d, folder / "run", {"--set", value}));
  };
  expectRefusal(set("perception.detectors=[nope]"), kUsage, {"nope", "apriltag, external"});
  expectRefusal(set("loops.prefilter.method=nope"), kUsage, {"nope", "always, motion, none"});
  expectRefusal(set("outputs=[trajectory, nope]"), kUsage,
                {"outputs", "nope", "session", "trajectory"});
  EXPECT_FALSE(fs::exists(folder / "run")) << "refused before anything is written";
}

TEST(Usage, ADumpThatCannotBeWrittenIsAnError) {
  const Outcome full = runCommand({"sh", "-c", "exec " DYNEMO_SLAM " --dump-config > /dev/full"});
  expectRefusal(full, 3, {"standard output"});
}

TEST(Usage, TheEvaluatorRefusesToo) {
  EXPECT_EQ(runCommand({DYNEMO_EVAL}).status, kUsage);
  EXPECT_EQ(runCommand({DYNEMO_EVAL, "--reference", "/nonexistent/a.tum", "/nonexistent"}).status,
            3);
}

}  // namespace
}  // namespace dynemo::test
