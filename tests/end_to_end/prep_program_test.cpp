// dynemo-prep as its user calls it, on the bundled sample and, where there is one, on a real bag.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/serialization/CArchive.h>

#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "dataset.h"
#include "dynemo/evaluation/entity_data.h"
#include "process.h"

namespace dynemo::test {
namespace {

using namespace std::chrono_literals;

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

TEST_F(Prep, AnImageFormatIsNamed) {
  for (const char* format : {"gif", "1"}) {
    const Outcome outcome =
        prep({"externalize-images", rawlog, "--format", format, "-o", path("o.rawlog")});
    EXPECT_EQ(outcome.status, 2) << describe(outcome);
    EXPECT_NE(outcome.err.find(std::string("--format: ") + format + ": must be png or jpg"),
              std::string::npos)
        << outcome.err;
  }
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
  // Nothing ties the two clocks, which the remedy does not pretend.
  EXPECT_EQ(check.out.find("--remap-timestamps"), std::string::npos) << check.out;
  EXPECT_NE(check.out.find("no remedy in this log"), std::string::npos) << check.out;
  EXPECT_NE(check.out.find("--remove-label base_pose_ground_truth"), std::string::npos);
  const Outcome slam = runCommand({DYNEMO_SLAM, "--output", path("run"), path("bag.rawlog")});
  EXPECT_EQ(slam.status, 0) << describe(slam);
  EXPECT_NE(slam.out.find("of 5 frames: the map is not to be trusted"), std::string::npos)
      << slam.out;
  const auto summary = nlohmann::json::parse(readBytes(folder / "run" / "summary.json"));
  EXPECT_EQ(summary["doubts"].size(), 1U) << summary["doubts"];
}

/// A log of ten seconds in which the stamps of one sensor are those of another clock.
class TwoClocks : public Prep {
 protected:
  void SetUp() override {
    if (runCommand({"sh", "-c", "command -v rawlog-edit"}).status != 0)
      GTEST_SKIP() << "rawlog-edit is not installed";
  }
  void write(const std::string& label, const std::string& other_clock_s) {
    shell("dynemo-prep trim " + rawlog +
          " --to 10 -o start.rawlog\n"
          "rawlog-edit -q -i start.rawlog -o own.rawlog --keep-label " +
          label + "\nrawlog-edit -q -i own.rawlog -o other.rawlog --remap-timestamps '1;" +
          other_clock_s + "'\n");
  }
  void shell(const std::string& commands) const {
    const std::string programs = fs::path(DYNEMO_PREP).parent_path().string();
    const Outcome outcome =
        runCommand({"sh", "-ec", "PATH=" + programs + ":$PATH\n" + commands}, folder.path());
    EXPECT_EQ(outcome.status, 0) << describe(outcome) << commands;
  }
  nlohmann::json checked(const std::string& name) const {
    return nlohmann::json::parse(prep({"check", "--json", path(name)}).out);
  }
  static std::string commandsFor(const nlohmann::json& check) {
    for (const auto& f : check["findings"])
      if (f["what"].get<std::string>().find("clock of its own") != std::string::npos)
        return f["commands"].get<std::string>();
    return {};
  }
  /// Largest distance of an object of the map of a log from the one of the same seconds as
  /// recorded.
  double objectsApart(const std::string& name) const {
    const auto objects = [&](const std::string& log) {
      const std::string run = path("run_" + log);
      const Outcome slam =
          runCommand({DYNEMO_SLAM, "--quiet", "--entities", sample.entities().string(), "--output",
                      run, path(log + ".rawlog")});
      EXPECT_EQ(slam.status, 0) << describe(slam);
      std::map<EntityId, Vector3> last;
      for (const auto& o : readEntityEstimates(run + "/entities.csv"))
        if (o.semantic_class == SemanticClass::kObject) last[o.entity] = o.T_map_entity.t;
      return last;
    };
    const auto expected = objects("start"), actual = objects(name);
    EXPECT_GE(expected.size(), 3U);
    double worst_m = 0.0;
    for (const auto& [id, p] : expected)
      worst_m = std::max(worst_m, actual.contains(id) ? (actual.at(id) - p).norm() : 1e9);
    return worst_m;
  }
};

/// A log as a recorder stores what it gets, with a sensor of the main clock every ten milliseconds
/// and the camera's stamps of another clock.
void writeWithHeartbeat(const fs::path& from, const fs::path& to, std::chrono::seconds ahead) {
  mrpt::io::CFileGZInputStream in(from.string());
  mrpt::io::CFileGZOutputStream out(to.string());
  auto source = mrpt::serialization::archiveFrom(in);
  auto sink = mrpt::serialization::archiveFrom(out);
  mrpt::obs::CObservationComment beat;
  beat.sensorLabel = "heartbeat";
  bool begun = false;
  try {
    while (true) {
      const auto o = source.ReadObject<mrpt::obs::CObservation>();
      if (!begun) beat.timestamp = o->timestamp;
      for (begun = true; beat.timestamp <= o->timestamp; beat.timestamp += 10ms) sink << beat;
      if (o->sensorLabel == "camera") o->timestamp += ahead;
      sink << *o;
    }
  } catch (const mrpt::serialization::CExceptionEOF&) {
  }
}

/// Recorded together: the order of the log ties the clocks. The commands that check prints, as they
/// are, and then dynemo-slam.
TEST_F(TwoClocks, RecordedTogetherArePutRightByTheCommandsOfCheck) {
  shell("dynemo-prep trim " + rawlog + " --to 10 -o start.rawlog");
  writeWithHeartbeat(folder / "start.rawlog", folder / "two clocks.rawlog", 5000s);
  shell("ln -s start_Images 'two clocks_Images'");
  const auto before = checked("two clocks.rawlog");
  EXPECT_EQ(before["clocks"], 2);
  for (const auto& sensor : before["sensors"]) {
    if (sensor["label"] != "camera") continue;
    EXPECT_NEAR(sensor["clock_offset_s"].get<double>(), 5000.0, 0.0051);
    EXPECT_LT(sensor["clock_uncertainty_s"].get<double>(), 0.0051);
  }
  shell(commandsFor(before));
  const auto after = checked("two clocks_one_clock.rawlog");
  EXPECT_EQ(after["runnable"], true);
  EXPECT_EQ(after["clocks"], 1);
  EXPECT_GT(after["images_searched"], 0);
  fs::rename(folder / "two clocks_one_clock.rawlog", folder / "mended.rawlog");
  shell("ln -s start_Images mended_Images");
  EXPECT_LT(objectsApart("mended"), 0.05);
}

/// A log in the order of stamps says nothing of what was recorded when, so that no map is built on
/// a guess: the sensor is left out.
TEST_F(TwoClocks, SortedByStampsAreTakenApart) {
  write("camera", "5000");
  shell(
      "rawlog-edit -q -i start.rawlog -o rest.rawlog --remove-label camera\n"
      "ln -s start_Images other_Images\nln -s start_Images rest_Images\n"
      "dynemo-prep merge rest.rawlog other.rawlog -o 'two clocks.rawlog'\n");
  const auto before = checked("two clocks.rawlog");
  EXPECT_EQ(before["runnable"], false);
  EXPECT_EQ(before["clocks"], 2);
  const std::string commands = commandsFor(before);
  EXPECT_EQ(commands.find("remap"), std::string::npos) << commands;
  shell(commands);
  const auto after = checked("two clocks_rest.rawlog");
  EXPECT_EQ(after["runnable"], true);
  EXPECT_EQ(after["clocks"], 1);
  EXPECT_EQ(after["sensors"].size(), before["sensors"].size() - 1);
}

}  // namespace
}  // namespace dynemo::test
