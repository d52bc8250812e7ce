// What dynemo-prep writes opens in MRPT's RawLogViewer, and its window lists what is in it.
#include <gtest/gtest.h>

#include <cstdlib>

#include "dataset.h"
#include "process.h"

namespace dynemo::test {
namespace {

bool installed(const std::string& program) {
  return runCommand({"sh", "-c", "command -v " + program}).status == 0;
}

class Viewer : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* program : {"RawLogViewer", "Xvfb", "xdotool", "import", "tesseract"})
      if (!installed(program)) GTEST_SKIP() << program << " is not installed";
  }
  void make(const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {DYNEMO_PREP};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Outcome outcome = runCommand(command);
    ASSERT_EQ(outcome.status, 0) << describe(outcome);
  }
  /// Fails unless the window shows each of the lines, given as patterns.
  void expectShown(const std::string& rawlog, const std::vector<std::string>& patterns) {
    const Outcome shown =
        runCommand({DYNEMO_SOURCE_DIR "/tests/end_to_end/rawlog_viewer_text.sh", rawlog});
    ASSERT_EQ(shown.status, 0) << describe(shown);
    for (const std::string& pattern : patterns)
      EXPECT_TRUE(::testing::internal::RE::PartialMatch(shown.out, pattern)) << pattern << " in\n"
                                                                             << shown.out;
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  const Dataset sample = bundledSample();
  TemporaryFolder folder;
};

TEST_F(Viewer, ListsTheDetectionsOfAnAnnotatedLog) {
  make({"annotate", sample.rawlog().string(), "--entities", sample.entities().string(), "-o",
        path("annotated.rawlog")});
  expectShown(path("annotated.rawlog"),
              {"131 .*CObservationPointCloud", "131 .*CObservationImage",
               "521 .*CObservationRobotPose", "[0-9]+ .*CObservation.DFeatures"});
}

TEST_F(Viewer, ListsWhatTheSimulatorRecorded) {
  expectShown(hallSample().rawlog().string(),
              {"151 .*CObservationPointCloud", "CObservationImage", "601 .*CObservationOdometry",
               "601 .*CObservationRobotPose"});
}

TEST_F(Viewer, ListsWhatIsLeftOfATrimmedAndRelabelledLog) {
  make({"trim", sample.rawlog().string(), "--from", "10", "--to", "20", "-o", path("part.rawlog")});
  make({"relabel", path("part.rawlog"), "--label", "camera=front", "-o", path("new.rawlog")});
  expectShown(path("new.rawlog"),
              {"25 .*CObservationPointCloud", "25 .*CObservationImage", "25 front"});
}

TEST_F(Viewer, ListsWhatIsLeftOfADecimatedLogWithOtherMountings) {
  make({"decimate", sample.rawlog().string(), "--label", "lidar", "--keep-every", "2", "-o",
        path("thin.rawlog")});
  make({"set-extrinsics", path("thin.rawlog"), "--sensor", "camera=0.2,0,0.45,-90,0,-90", "-o",
        path("placed.rawlog")});
  writeBytes(path("camera.yaml"), readBytes(DYNEMO_SOURCE_DIR "/tests/guides/camera.yaml"));
  make({"set-calibration", path("placed.rawlog"), "--label", "camera", "--file",
        path("camera.yaml"), "-o", path("calibrated.rawlog")});
  make({"externalize-images", path("calibrated.rawlog"), "-o", path("outside.rawlog")});
  expectShown(path("outside.rawlog"), {"66 .*CObservationPointCloud", "131 .*CObservationImage",
                                       "521 .*CObservationRobotPose"});
}

TEST_F(Viewer, ListsPartsOfASplitLogThatWereJoined) {
  make({"split", sample.rawlog().string(), "--every", "20", "-o", path("part.rawlog")});
  make({"merge", path("part_01.rawlog"), path("part_02.rawlog"), "-o", path("joined.rawlog")});
  expectShown(path("joined.rawlog"),
              {"10[08] .*CObservationPointCloud", "10[08] .*CObservationImage"});  // OCR
}

TEST_F(Viewer, ListsTheCloudsOfAnImportedBag) {
  const char* data = std::getenv("DYNEMO_REAL_DATA");
  if (data == nullptr || *data == '\0') GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
  make({"import", std::string(data) + "/bags/embag_test_luminar.bag", "-o", path("bag.rawlog")});
  expectShown(path("bag.rawlog"), {"5 .*CObservationPointCloud", "5 .*CObservationRobotPose"});
}

}  // namespace
}  // namespace dynemo::test
