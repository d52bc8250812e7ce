// dynemo-prep as its user calls it, on the bundled sample and, where there is one, on a real bag.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "dataset.h"
#include "process.h"

namespace dynemo::test {
namespace {

Outcome prep(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), DYNEMO_PREP);
  return runCommand(arguments);
}

class Prep : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder / name).string(); }
  const Dataset sample = bundledSample();
  const std::string rawlog = sample.rawlog().string();
  TemporaryFolder folder;
};

TEST_F(Prep, HelpNamesEveryCommand) {
  const Outcome help = prep({"--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* command :
       {"check", "tags", "trim", "split", "decimate", "merge", "set-extrinsics", "set-calibration",
        "relabel", "externalize-images", "annotate", "import", "export"}) {
    EXPECT_NE(help.out.find(command), std::string::npos) << command;
    EXPECT_EQ(prep({command, "--help"}).status, 0) << command;
    EXPECT_EQ(prep({command}).status, 2) << command;
  }
  EXPECT_EQ(prep({}).status, 2);
  EXPECT_EQ(prep({"nope"}).status, 2);
}

TEST_F(Prep, CheckSaysWhetherItCanRun) {
  const Outcome good = prep({"check", rawlog});
  EXPECT_EQ(good.status, 0) << describe(good);
  EXPECT_NE(good.out.find("dynemo-slam can run it: 131 frames"), std::string::npos) << good.out;
  const auto json = nlohmann::json::parse(prep({"check", "--json", rawlog}).out);
  EXPECT_EQ(json["runnable"], true);
  EXPECT_EQ(json["sensors"].size(), 4U);
  EXPECT_GT(json["tags"].size(), 10U);

  ASSERT_EQ(prep({"relabel", rawlog, "-o", path("two.rawlog"), "--label", "odom3d=other"}).status,
            0);
  ASSERT_EQ(prep({"merge", path("two.rawlog"), rawlog, "-o", path("both.rawlog")}).status, 0);
  const Outcome open = prep({"check", path("both.rawlog")});
  EXPECT_EQ(open.status, 1) << describe(open);
  EXPECT_NE(open.out.find("sensors.odometry.label"), std::string::npos);
  EXPECT_EQ(prep({"check", path("both.rawlog"), "--set", "sensors.odometry.label=odom3d"}).status,
            0);
}

TEST_F(Prep, MissingAndWrongFilesAreOneErrorEach) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"check", path("missing.rawlog")},
        {"trim", path("missing.rawlog"), "-o", path("o.rawlog")},
        {"import", path("missing.bag"), "-o", path("o.rawlog")},
        {"import", rawlog, "-o", path("o.rawlog")},
        {"trim", rawlog, "-o", rawlog}}) {
    const Outcome outcome = prep(arguments);
    EXPECT_EQ(outcome.status, 3) << describe(outcome);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.out.empty());
  }
  EXPECT_FALSE(fs::exists(path("o.rawlog")));
}

TEST_F(Prep, APoseThatIsNoneIsAnsweredWithBothForms) {
  for (const char* sensor : {"camera=1,2,3", "camera", "camera=1,2,3,4,5,6,7,8"}) {
    const Outcome outcome =
        prep({"set-extrinsics", rawlog, "-o", path("o.rawlog"), "--sensor", sensor});
    EXPECT_EQ(outcome.status, 2) << describe(outcome);
    for (const char* form : {"X,Y,Z,YAW,PITCH,ROLL", "X,Y,Z,QX,QY,QZ,QW"})
      EXPECT_NE(outcome.err.find(form), std::string::npos) << describe(outcome);
  }
  EXPECT_EQ(prep({"set-extrinsics", rawlog, "-o", path("six.rawlog"), "--sensor",
                  "camera=0.2,0,0.45,-90,0,-90"})
                .status,
            0);
}

TEST_F(Prep, BoundsOfNumbersAreTold) {
  const Outcome outcome = prep({"check", rawlog, "--tag-images", "-1"});
  EXPECT_EQ(outcome.status, 2) << describe(outcome);
  EXPECT_NE(outcome.err.find("--tag-images: -1: must be a number >= 0"), std::string::npos)
      << outcome.err;
}

TEST_F(Prep, TheDraftedEntityFileRuns) {
  const Outcome tags = prep({"tags", rawlog, "-o", path("entities.yaml")});
  ASSERT_EQ(tags.status, 0) << describe(tags);
  const Outcome slam = runCommand({DYNEMO_SLAM, "--entities", path("entities.yaml"), "--output",
                                   path("run"), "--set", "outputs=[trajectory]", rawlog});
  EXPECT_EQ(slam.status, 0) << describe(slam);
  EXPECT_EQ(prep({"tags", rawlog, "-o", path("entities.yaml")}).status, 3) << "is not overwritten";
}

TEST_F(Prep, AnAnnotatedLogGivesTheSameMapWithoutACamera) {
  const std::string entities = sample.entities().string();
  const Outcome annotated = prep({"annotate", rawlog, "--entities", entities, "--drop-images", "-o",
                                  path("annotated.rawlog")});
  ASSERT_EQ(annotated.status, 0) << describe(annotated);
  const auto summaryOf = [&](const std::string& log, const std::string& run) {
    const Outcome slam =
        runCommand({DYNEMO_SLAM, "--entities", entities, "--output", path(run), log});
    EXPECT_EQ(slam.status, 0) << describe(slam);
    return nlohmann::json::parse(readBytes(folder / run / "summary.json"));
  };
  const auto seen = summaryOf(rawlog, "seen"),
             stored = summaryOf(path("annotated.rawlog"), "stored");
  EXPECT_EQ(stored["keyframes"]["count"], seen["keyframes"]["count"]);
  ASSERT_EQ(stored["entities"].size(), seen["entities"].size());
  for (std::size_t i = 0; i < seen["entities"].size(); ++i) {
    EXPECT_EQ(stored["entities"][i]["id"], seen["entities"][i]["id"]);
    EXPECT_EQ(stored["entities"][i]["moved"], seen["entities"][i]["moved"]);
    EXPECT_EQ(stored["entities"][i]["observations"], seen["entities"][i]["observations"]);
  }
}

TEST_F(Prep, AnAnnotatedLogStillNeedsTheEntityFile) {
  ASSERT_EQ(prep({"annotate", rawlog, "--entities", sample.entities().string(), "--drop-images",
                  "-o", path("annotated.rawlog")})
                .status,
            0);
  const Outcome check = prep({"check", path("annotated.rawlog")});
  EXPECT_EQ(check.status, 0) << describe(check);
  EXPECT_NE(check.out.find("entity file, which dynemo-slam still needs"), std::string::npos);
  EXPECT_EQ(check.out.find("gaps, the longest"), std::string::npos) << check.out;
  const Outcome slam = runCommand({DYNEMO_SLAM, "--output", path("run"), "--set",
                                   "outputs=[trajectory]", path("annotated.rawlog")});
  EXPECT_EQ(slam.status, 0) << describe(slam);
  EXPECT_NE(slam.out.find("warning     260 entity detections were left out: without --entities"),
            std::string::npos)
      << slam.out;
}

TEST_F(Prep, RealBagsGiveTheirClouds) {
  const char* data = std::getenv("DYNEMO_REAL_DATA");
  if (data == nullptr || *data == '\0') GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
  const std::string bag = std::string(data) + "/bags/embag_test_luminar.bag";
  const Outcome imported = prep({"import", bag, "-o", path("bag.rawlog")});
  ASSERT_EQ(imported.status, 0) << describe(imported);
  const auto json = nlohmann::json::parse(prep({"check", "--json", path("bag.rawlog")}).out);
  bool found = false;
  for (const auto& sensor : json["sensors"]) {
    if (sensor["label"] != "luminar_pointcloud") continue;
    found = true;
    EXPECT_EQ(sensor["class"], "CObservationPointCloud");
    EXPECT_EQ(sensor["count"], 5);
    EXPECT_NEAR(std::stod(sensor["first"].get<std::string>()), 1583971570.0153, 1e-4);
  }
  EXPECT_TRUE(found) << json.dump(1);

  std::vector<std::size_t> sizes;
  copyRawlog(folder / "bag.rawlog", folder / "copy.rawlog", [&](const auto& observation) {
    const auto* cloud = dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&observation);
    if (cloud) sizes.push_back(cloud->pointcloud->size());
    return true;
  });
  EXPECT_EQ(sizes, (std::vector<std::size_t>{35707, 36055, 36267, 36457, 36336}));

  // Its odometry has a clock of its own, and five clouds of a car do not fit together: no map.
  const Outcome check = prep({"check", path("bag.rawlog")});
  EXPECT_EQ(check.status, 1) << describe(check);
  for (const char* part : {", 0.4 s from 1583971570.0152996", "stamps of 2 clocks",
                           "base_pose_ground_truth' (CObservationRobotPose): its stamps differ by",
                           "the log's odometry cannot be used, and the scans alone do not do"})
    EXPECT_NE(check.out.find(part), std::string::npos) << part << "\n" << check.out;
  EXPECT_EQ(check.out.find("-0.0 "), std::string::npos) << check.out;
  const Outcome slam = runCommand({DYNEMO_SLAM, "--output", path("run"), path("bag.rawlog")});
  EXPECT_EQ(slam.status, 0) << describe(slam);
  EXPECT_NE(slam.out.find("of 5 frames: the map is not to be trusted"), std::string::npos)
      << slam.out;
  const auto summary = nlohmann::json::parse(readBytes(folder / "run" / "summary.json"));
  EXPECT_EQ(summary["doubts"].size(), 1U) << summary["doubts"];
}

/// The commands that check prints, as they are.
TEST_F(Prep, AClockIsPutRightByTheCommandsOfCheck) {
  if (runCommand({"sh", "-c", "command -v rawlog-edit"}).status != 0)
    GTEST_SKIP() << "rawlog-edit is not installed";
  const auto shell = [&](const std::string& commands) {
    const std::string programs = fs::path(DYNEMO_PREP).parent_path().string();
    const Outcome outcome =
        runCommand({"sh", "-ec", "PATH=" + programs + ":$PATH\n" + commands}, folder.path());
    EXPECT_EQ(outcome.status, 0) << describe(outcome) << commands;
  };
  shell("dynemo-prep trim " + rawlog +
        " --to 10 -o start.rawlog\n"
        "rawlog-edit -q -i start.rawlog -o camera.rawlog --keep-label camera\n"
        "rawlog-edit -q -i camera.rawlog -o late.rawlog --remap-timestamps '1;5000'\n"
        "rawlog-edit -q -i start.rawlog -o rest.rawlog --remove-label camera\n"
        "ln -s start_Images late_Images\nln -s start_Images rest_Images\n"
        "dynemo-prep merge rest.rawlog late.rawlog -o 'two clocks.rawlog'\n");
  const std::string two_clocks = path("two clocks.rawlog");
  const auto before = nlohmann::json::parse(prep({"check", "--json", two_clocks}).out);
  EXPECT_EQ(before["clocks"], 2);
  std::string commands;
  for (const auto& f : before["findings"])
    if (f["what"].get<std::string>().find("clock of its own") != std::string::npos)
      commands = f["commands"].get<std::string>();
  shell(commands);
  const Outcome after = prep({"check", "--json", path("two clocks_one_clock.rawlog")});
  EXPECT_EQ(after.status, 0) << describe(after);
  const auto json = nlohmann::json::parse(after.out);
  EXPECT_EQ(json["clocks"], 1);
  EXPECT_GT(json["images_searched"], 0);
}

}  // namespace
}  // namespace dynemo::test
