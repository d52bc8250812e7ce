// set-extrinsics, set-calibration and relabel.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <opencv2/core.hpp>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/prep/rewrite.h"
#include "generated_rawlog.h"
#include "written_log.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-9;

const char* const kCalibration = R"(image_width: 64
image_height: 48
camera_name: test
camera_matrix:
  rows: 3
  cols: 3
  data: [70.5, 0, 31, 0, 71.5, 23, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.01, 0.02, 0.003, 0.004, 0.05]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [70.5, 0, 31, 0, 0, 71.5, 23, 0, 0, 0, 1, 0]
)";

class SensorEdits : public ::testing::Test {
 protected:
  void SetUp() override { writeLog(input, {.duration_s = 1.0}); }
  Pose3 poseOf(const WrittenObservation& o) {
    mrpt::poses::CPose3D pose;
    o.object->getSensorPose(pose);
    return fromMrpt(pose);
  }
  TemporaryFolder folder;
  fs::path input = folder / "in.rawlog", output = folder / "out.rawlog";
};

TEST_F(SensorEdits, ExtrinsicsChangeTheNamedSensorsOnly) {
  const Pose3 T = Pose3::fromYawPitchRoll(1, 2, 3, 0.4, 0.5, 0.6);
  const auto report = setExtrinsics(input, output, {{"lidar", T}}, {});
  EXPECT_EQ(report.edited, (std::map<std::string, std::uint64_t>{{"lidar", 11}}));
  const auto before = readLog(input), after = readLog(output);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].label == "lidar")
      EXPECT_LT(local(T, poseOf(after[i])).norm(), kTolerance);
    else
      EXPECT_EQ(after[i].bytes, before[i].bytes);
  }
  EXPECT_THROW(setExtrinsics(input, folder / "o.rawlog", {{"nope", T}}, {}), ConfigError);
  EXPECT_FALSE(fs::exists(folder / "o.rawlog"));
}

TEST_F(SensorEdits, ObservationsInSensoryFramesAreReachedToo) {
  {
    RawlogWriter out(folder / "frames.rawlog");
    mrpt::obs::CSensoryFrame frame;
    frame.insert(std::make_shared<mrpt::obs::CObservationPointCloud>(cloudObservation(0.0)));
    out.write(frame);
  }
  const Pose3 T = Pose3::translation(7, 8, 9);
  setExtrinsics(folder / "frames.rawlog", output, {{"lidar", T}}, {});
  RawlogReader reader(output, std::size_t{1} << 30);
  const auto entry = reader.next();
  const auto& frame = dynamic_cast<const mrpt::obs::CSensoryFrame&>(*entry->object);
  mrpt::poses::CPose3D pose;
  (*frame.begin())->getSensorPose(pose);
  EXPECT_LT(local(T, fromMrpt(pose)).norm(), kTolerance);
}

TEST_F(SensorEdits, CalibrationIsReadAndSet) {
  writeFile(folder / "camera.yaml", kCalibration);
  const auto camera = readCalibration(folder / "camera.yaml");
  const auto report = setCalibration(input, output, "camera", camera, {});
  EXPECT_EQ(report.edited, (std::map<std::string, std::uint64_t>{{"camera", 11}}));
  EXPECT_TRUE(report.warnings.empty());
  for (const auto& o : readLog(output)) {
    if (o.label != "camera") continue;
    const auto& image = dynamic_cast<mrpt::obs::CObservationImage&>(*o.object);
    EXPECT_EQ(image.cameraParams.fx(), 70.5);
    EXPECT_EQ(image.cameraParams.cy(), 23.0);
    EXPECT_EQ(image.cameraParams.p2(), 0.004);
    EXPECT_EQ(image.cameraParams.k3(), 0.05);
  }
}

TEST_F(SensorEdits, EditedImagesKeepTheirPixels) {
  {
    RawlogWriter out(input);
    out.write(imageObservation(0.0, "camera", 3));
  }
  writeFile(folder / "camera.yaml", kCalibration);
  setCalibration(input, output, "camera", readCalibration(folder / "camera.yaml"), {});
  const auto pixels = [](const fs::path& log) {
    return dynamic_cast<mrpt::obs::CObservationImage&>(*readLog(log).front().object)
        .image.asCvMat<cv::Mat>(mrpt::img::DEEP_COPY);
  };
  EXPECT_EQ(cv::norm(pixels(input), pixels(output), cv::NORM_INF), 0.0);
}

TEST_F(SensorEdits, WrongCalibrationsAreRefused) {
  EXPECT_THROW(readCalibration(folder / "missing.yaml"), ConfigError);
  writeFile(folder / "empty.yaml", "");
  EXPECT_THROW(readCalibration(folder / "empty.yaml"), ConfigError);
  EXPECT_THROW(readCalibration(folder / "."), ConfigError);
  writeFile(folder / "binary.yaml", "\x1f\x8b\x08\xff");
  testing::internal::CaptureStderr();
  EXPECT_THROW(readCalibration(folder / "binary.yaml"), ConfigError);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  writeFile(folder / "other.yaml", "a: 1\nb: 2\n");
  try {
    readCalibration(folder / "other.yaml");
    ADD_FAILURE() << "accepted";
  } catch (const ConfigError& e) {
    EXPECT_EQ(std::string(e.what()).find("===="), std::string::npos) << e.what();
  }
  std::string zero = kCalibration;
  zero.replace(zero.find("70.5"), 4, "0.00");
  writeFile(folder / "zero.yaml", zero);
  EXPECT_THROW(readCalibration(folder / "zero.yaml"), ConfigError);
  writeFile(folder / "camera.yaml", kCalibration);
  const auto camera = readCalibration(folder / "camera.yaml");
  EXPECT_THROW(setCalibration(input, output, "lidar", camera, {}), ConfigError);
  EXPECT_THROW(setCalibration(input, output, "nope", camera, {}), ConfigError);
  EXPECT_FALSE(fs::exists(output));
}

TEST_F(SensorEdits, ACalibrationOfAnotherSizeIsCounted) {
  std::string wide = kCalibration;
  wide.replace(wide.find("64"), 2, "65");
  writeFile(folder / "camera.yaml", wide);
  const auto report =
      setCalibration(input, output, "camera", readCalibration(folder / "camera.yaml"), {});
  EXPECT_EQ(report.warnings.at("image whose size is not that of the calibration"), 11U);
}

TEST_F(SensorEdits, RelabelByClass) {
  {
    RawlogWriter out(input);
    out.write(cloudObservation(0.0, 10, "front"));
    out.write(imageObservation(0.0, "front"));
    out.write(poseObservation(0.0, "odometry"));
  }
  relabelRawlog(input, output,
                {{"front", "front_camera", "CObservationImage"}, {"odometry", "odom", ""}},
                SameLabel::kRefuse, {});
  EXPECT_EQ(countByLabel(readLog(output)),
            (std::map<std::string, int>{{"front", 1}, {"front_camera", 1}, {"odom", 1}}));
  EXPECT_THROW(
      relabelRawlog(input, folder / "o.rawlog", {{"nope", "x", ""}}, SameLabel::kRefuse, {}),
      ConfigError);
  EXPECT_FALSE(fs::exists(folder / "o.rawlog"));
}

TEST_F(SensorEdits, RelabelMakesNoTwoSensorsOneUnlessAsked) {
  {
    RawlogWriter out(input);
    for (const char* label : {"left", "right", "top"}) out.write(cloudObservation(0.0, 10, label));
  }
  const auto relabel = [&](const std::vector<LabelChange>& changes, SameLabel same_label) {
    fs::remove(output);
    relabelRawlog(input, output, changes, same_label, {});
    return countByLabel(readLog(output));
  };
  for (const auto& changes :
       {std::vector<LabelChange>{{"left", "right", ""}},
        std::vector<LabelChange>{{"left", "lidar", ""}, {"top", "lidar", ""}}}) {
    EXPECT_THROW(relabel(changes, SameLabel::kRefuse), ConfigError);
    EXPECT_FALSE(fs::exists(output));
  }
  EXPECT_EQ(relabel({{"left", "right", ""}}, SameLabel::kMerge),
            (std::map<std::string, int>{{"right", 2}, {"top", 1}}));
  // Labels that change places stay apart.
  EXPECT_EQ(relabel({{"left", "right", ""}, {"right", "left", ""}}, SameLabel::kRefuse),
            (std::map<std::string, int>{{"left", 1}, {"right", 1}, {"top", 1}}));
}

}  // namespace
}  // namespace dynemo::test
