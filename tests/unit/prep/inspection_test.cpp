// check: what is in a log and what is wrong with it.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "dynemo/core/error.h"
#include "dynemo/prep/inspection.h"
#include "generated_rawlog.h"

namespace dynemo::test {
namespace {

/// A room with walls askew, 8 m wide, seen from a robot that drives along x at 0.5 m/s.
mrpt::obs::CObservationPointCloud roomObservation(double seconds) {
  auto o = cloudObservation(seconds);
  o.sensorPose = {};
  const auto cloud = mrpt::maps::CSimplePointsMap::Create();
  const auto add = [&](double x, double y, double z) {
    cloud->insertPoint(static_cast<float>(x - 0.5 * seconds), static_cast<float>(y),
                       static_cast<float>(z));
  };
  constexpr double kSpacing_m = 0.15;
  for (double a = -4; a <= 4; a += kSpacing_m) {
    for (double b = -4; b <= 4; b += kSpacing_m) add(a, b, -0.4);
    for (double z = -0.4; z < 2.0; z += kSpacing_m) {
      add(a, 4, z);
      add(a, -4, z);
      add(4 + 0.2 * a, a, z);
      add(-4, a, z);
    }
  }
  o.pointcloud = cloud;
  return o;
}

class Check : public ::testing::Test {
 protected:
  Inspection inspect() { return inspectRawlog(log, params); }
  static const SensorInspection& sensor(const Inspection& inspection, const std::string& label) {
    for (const auto& s : inspection.sensors)
      if (s.label == label) return s;
    throw std::out_of_range(label);
  }
  /// The finding whose text contains the words, with its severity; fails when there is none.
  static Finding finding(const Inspection& inspection, const std::string& words) {
    for (const Finding& f : inspection.findings)
      if (f.what.find(words) != std::string::npos) return f;
    ADD_FAILURE() << "no finding about '" << words << "' in\n" << inspectionText(inspection);
    return {};
  }
  static bool hasFinding(const Inspection& inspection, const std::string& words) {
    for (const Finding& f : inspection.findings)
      if (f.what.find(words) != std::string::npos) return true;
    return false;
  }
  TemporaryFolder folder;
  fs::path log = folder / "log.rawlog";
  InspectionParams params;
};

TEST_F(Check, CountsRatesAndCalibration) {
  writeLog(log, {});
  const auto inspection = inspect();
  EXPECT_TRUE(inspection.runnable());
  EXPECT_EQ(inspection.frames, 51U);
  ASSERT_EQ(inspection.sensors.size(), 3U);
  const auto& lidar = sensor(inspection, "lidar");
  EXPECT_EQ(lidar.class_name, "CObservationPointCloud");
  EXPECT_EQ(lidar.use, UseOfSensor::kScan);
  EXPECT_EQ(lidar.count, 51U);
  EXPECT_NEAR(lidar.rate_hz(), 10.0, 1e-6);
  EXPECT_EQ(lidar.gaps, 0U);
  EXPECT_EQ(lidar.scan->min_points, 100U);
  EXPECT_EQ(lidar.scan->max_points, 100U);
  EXPECT_LT(local(*lidar.T_base_sensor, kBaseFromLidar).norm(), 1e-6);
  const auto& camera = sensor(inspection, "camera");
  EXPECT_EQ(camera.camera->width, 64);
  EXPECT_EQ(camera.camera->fx, 60.0);
  EXPECT_EQ(camera.camera->embedded, 51U);
  EXPECT_EQ(sensor(inspection, "odom3d").use, UseOfSensor::kOdometry);
  EXPECT_NEAR(sensor(inspection, "odom3d").rate_hz(), 20.0, 1e-6);
  EXPECT_EQ(inspection.first, at(0.0));
  EXPECT_EQ(inspection.last, at(5.0));
}

TEST_F(Check, ALogWithoutAnythingUsableCannotRun) {
  {
    RawlogWriter out(log);
    mrpt::obs::CObservation2DRangeScan scan;
    scan.timestamp = mrptTime(0);
    scan.sensorLabel = "laser";
    out.write(scan);
  }
  const auto inspection = inspect();
  EXPECT_FALSE(inspection.runnable());
  EXPECT_EQ(inspection.findings.front().severity, Severity::kError);
  EXPECT_FALSE(inspection.findings.front().fix.empty());
  EXPECT_EQ(sensor(inspection, "laser").use, UseOfSensor::kNotUsed);
}

TEST_F(Check, SeveralLidarsMustBeChosenFrom) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 30; ++i) {
      out.write(poseObservation(0.1 * i));
      out.write(cloudObservation(0.1 * i, 10, "front"));
      out.write(cloudObservation(0.1 * i, 10, "rear"));
    }
  }
  auto inspection = inspect();
  EXPECT_FALSE(inspection.runnable());
  EXPECT_EQ(finding(inspection, "sensors.lidar.label").severity, Severity::kError);
  params.sensors.lidar.label = "front";
  inspection = inspect();
  EXPECT_TRUE(inspection.runnable());
  EXPECT_EQ(inspection.frames, 30U);
}

TEST_F(Check, GapsAndJumpsAreFoundWhereTheyAre) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 100; ++i)
      if (i < 40 || i >= 60) out.write(cloudObservation(0.1 * i, 10));
    for (int i = 0; i < 20; ++i) out.write(cloudObservation(5.0 + 0.1 * i, 10));
  }
  const auto inspection = inspect();
  const auto& lidar = sensor(inspection, "lidar");
  EXPECT_EQ(lidar.gaps, 1U);
  EXPECT_NEAR(lidar.longest_gap_s, 2.1, 1e-6);
  EXPECT_EQ(lidar.longest_gap_at, at(3.9));
  EXPECT_EQ(lidar.jumps_back, 1U);
  finding(inspection, "1 gaps, the longest of 2.10 s");
  finding(inspection, "stamps jump back 1 times");
}

TEST_F(Check, AnotherClockIsFound) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 50; ++i) {
      out.write(cloudObservation(0.1 * i, 10));
      out.write(poseObservation(0.1 * i));
      out.write(imageObservation(0.1 * i + 0.01 + 1000.0));
      for (int k = 1; k < 5; ++k) out.write(poseObservation(0.1 * i + 0.02 * k));
    }
  }
  const auto inspection = inspect();
  const SensorInspection& camera = sensor(inspection, "camera");
  EXPECT_TRUE(camera.other_clock);
  // Between two poses, which tells more than between two scans.
  ASSERT_TRUE(camera.clock_tie);
  EXPECT_NEAR(camera.clock_tie->uncertainty_s, 0.01, 1e-6);
  EXPECT_NEAR(camera.clock_offset_s, 1000.0, 1e-6);
  EXPECT_FALSE(sensor(inspection, "odom3d").other_clock);
  EXPECT_FALSE(inspection.runnable());
  const Finding clock = finding(inspection, "clock of its own");
  EXPECT_NE(clock.what.find("(+- 0.010 s)"), std::string::npos) << clock.what;
  for (const std::string& part :
       {"-i " + log.string() + " ", std::string("--keep-label camera\n"),
        std::string("--remap-timestamps '1;-1000.000'\n"), std::string("--remove-label camera\n"),
        "-o " + (folder / "log_one_clock.rawlog").string()})
    EXPECT_NE(clock.commands.find(part), std::string::npos) << part << " in\n" << clock.commands;
  EXPECT_EQ(clockCount(inspection), 2U);
  EXPECT_NEAR(secondsBetween(*inspection.first, *inspection.last), 4.98, 1e-6);
  EXPECT_NE(inspectionText(inspection).find(", 5.0 s from "), std::string::npos);
  EXPECT_NE(inspectionText(inspection).find(", stamps of 2 clocks\n"), std::string::npos);
}

/// Half a second between two observations of the other clock's neighbours leaves the robot's motion
/// of that time open.
TEST_F(Check, AClockThatIsTiedLooselyIsNotPutRight) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 50; ++i) {
      out.write(cloudObservation(0.5 * i, 10));
      out.write(imageObservation(0.5 * i + 0.2 + 1000.0));
    }
  }
  const auto inspection = inspect();
  ASSERT_TRUE(sensor(inspection, "camera").clock_tie);
  EXPECT_NEAR(sensor(inspection, "camera").clock_tie->uncertainty_s, 0.25, 1e-6);
  const Finding clock = finding(inspection, "clock of its own");
  EXPECT_NE(clock.what.find("only to 0.250 s"), std::string::npos) << clock.what;
  EXPECT_EQ(clock.commands.find("remap"), std::string::npos) << clock.commands;
  EXPECT_NE(clock.commands.find("--remove-label camera"), std::string::npos) << clock.commands;
}

/// A log whose odometry has a clock of its own.
void writeOdometryOfAnotherClock(const fs::path& log,
                                 mrpt::obs::CObservationPointCloud (*scan)(double seconds)) {
  RawlogWriter out(log);
  for (int i = 0; i < 60; ++i) {
    out.write(scan(0.1 * i));
    out.write(poseObservation(0.1 * i - 1.5e9));
  }
}

TEST_F(Check, OdometryOfAnotherClockIsReplacedByTheScansWhereTheyDo) {
  writeOdometryOfAnotherClock(log, roomObservation);
  auto inspection = inspect();
  EXPECT_TRUE(inspection.runnable()) << inspectionText(inspection);
  EXPECT_EQ(inspection.frames, 60U);
  EXPECT_EQ(inspection.frames_with_odometry, 0U);
  ASSERT_TRUE(inspection.odometry_trial);
  EXPECT_EQ(inspection.odometry_trial->scans, 59U);
  EXPECT_EQ(inspection.odometry_trial->followed, 59U);
  EXPECT_EQ(finding(inspection, "clock of its own").severity, Severity::kWarning);
  EXPECT_EQ(finding(inspection, "clock of its own").commands, "") << "the scans do";
  EXPECT_EQ(finding(inspection, "59 of 59 scans tried fit together").severity, Severity::kWarning);
  // In stretches, each with a first scan that has nothing to fit to.
  params.odometry_scans = 50;
  inspection = inspect();
  EXPECT_EQ(inspection.odometry_trial->scans, 48U);
  params.odometry_scans = 0;
  EXPECT_FALSE(inspect().odometry_trial);
}

TEST_F(Check, OdometryOfAnotherClockIsAnErrorWhereTheScansDoNot) {
  writeOdometryOfAnotherClock(log, [](double seconds) { return cloudObservation(seconds, 10); });
  const auto inspection = inspect();
  EXPECT_FALSE(inspection.runnable()) << inspectionText(inspection);
  const Finding f = finding(inspection, "the scans alone do not do");
  EXPECT_EQ(f.severity, Severity::kError);
  EXPECT_NE(f.what.find("LiDAR odometry: "), std::string::npos) << f.what;
}

TEST_F(Check, OdometryThatIsNamedButFitsNoScanIsAnError) {
  writeOdometryOfAnotherClock(log, roomObservation);
  params.odometry.source = OdometrySource::kRawlog;
  const auto inspection = inspect();
  EXPECT_FALSE(inspection.runnable());
  finding(inspection, "odometry.source");
}

TEST_F(Check, FramesWithoutOdometryAreCounted) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 60; ++i) {
      out.write(cloudObservation(0.1 * i));
      if (i < 30) out.write(poseObservation(0.1 * i));
    }
  }
  const auto inspection = inspect();
  EXPECT_TRUE(inspection.runnable());
  EXPECT_EQ(finding(inspection, " of 60 frames have no odometry").severity, Severity::kWarning);
}

TEST_F(Check, DetectionsAreEventsAndNeedTheEntityFile) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 300; ++i) {
      out.write(cloudObservation(0.1 * i));
      out.write(poseObservation(0.1 * i));
      const bool in_view = (i < 20) || (i > 150 && i < 170);
      if (in_view) out.write(featuresObservation(0.1 * i, 3, Pose3::translation(2, 0, 0)));
    }
  }
  const auto inspection = inspect();
  EXPECT_FALSE(hasFinding(inspection, "gap")) << inspectionText(inspection);
  EXPECT_EQ(sensor(inspection, "detector").gaps, 0U);
  EXPECT_NE(
      finding(inspection, "entity file, which dynemo-slam still needs").fix.find("--entities"),
      std::string::npos);
}

TEST_F(Check, ZeroHasNoSign) {
  {
    RawlogWriter out(log);
    auto o = roomObservation(0.0);
    o.sensorPose = mrpt::poses::CPose3D(-0.0001, 0, 0, 0, -1e-9, 0);
    out.write(o);
  }
  EXPECT_NE(inspectionText(inspect()).find("(0.000 0.000 0.000) m, yaw 0.0 pitch 0.0 roll 0.0 deg"),
            std::string::npos)
      << inspectionText(inspect());
}

TEST_F(Check, AnotherClockIsMeasuredInASortedLogToo) {
  for (const double offset_s : {1000.0, -1000.0}) {
    {
      RawlogWriter out(log);
      const auto images = [&] {
        for (int i = 0; i < 50; ++i) out.write(imageObservation(0.4 * i + offset_s));
      };
      if (offset_s < 0) images();
      for (int i = 0; i < 200; ++i) out.write(cloudObservation(0.1 * i, 10));
      if (offset_s > 0) images();
    }
    const auto inspection = inspect();
    EXPECT_TRUE(sensor(inspection, "camera").other_clock);
    EXPECT_NEAR(sensor(inspection, "camera").clock_offset_s, offset_s, 1e-3);
    // That both began together is a guess, which nothing is built on.
    EXPECT_FALSE(sensor(inspection, "camera").clock_tie);
    const Finding clock = finding(inspection, "clock of its own");
    EXPECT_NE(clock.what.find("nothing in the log ties the clocks"), std::string::npos);
    EXPECT_NE(clock.fix.find("no remedy"), std::string::npos);
    EXPECT_EQ(clock.commands, "rawlog-edit -q -i " + log.string() + " -o " +
                                  (folder / "log_rest.rawlog").string() + " --remove-label camera");
  }
}

TEST_F(Check, ASensorThatStartsEarlierHasNoOtherClock) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 600; ++i) {
      if (i >= 100 && i < 200) out.write(cloudObservation(0.1 * i, 10));
      out.write(poseObservation(0.1 * i));
    }
  }
  EXPECT_FALSE(sensor(inspect(), "odom3d").other_clock);
}

TEST_F(Check, AWrongLabelIsAnErrorWithAWayOut) {
  writeLog(log, {});
  params.sensors.lidar.label = "velo";
  bool found = false;
  for (const Finding& f : inspectRawlog(log, params).findings)
    found |= f.what.find("'velo'") != std::string::npos && f.fix.find("name ") == 0;
  EXPECT_TRUE(found);
}

TEST_F(Check, CalibrationAndMountingAreMissed) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 20; ++i) {
      auto o = imageObservation(0.1 * i);
      o.cameraParams = {};
      o.cameraPose = {};
      out.write(o);
    }
  }
  const auto inspection = inspect();
  EXPECT_NE(finding(inspection, "no calibration").fix.find("set-calibration --label camera"),
            std::string::npos);
  EXPECT_NE(finding(inspection, "looks straight up").fix.find("set-extrinsics"), std::string::npos);
}

TEST_F(Check, MissingImageFilesAreCounted) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 20; ++i) {
      auto o = imageObservation(0.1 * i);
      o.image.setExternalStorage("nowhere" + std::to_string(i) + ".png");
      out.write(o);
      out.write(cloudObservation(0.1 * i));
    }
  }
  const auto inspection = inspect();
  EXPECT_EQ(sensor(inspection, "camera").camera->external_missing, 20U);
  const Finding f = finding(inspection, "20 of 20 image files are missing: no entity can be found");
  EXPECT_NE(f.fix.find("log_Images"), std::string::npos);
  EXPECT_EQ(f.severity, Severity::kError);
}

TEST_F(Check, MissingImageFilesAreNoErrorWhereDetectionsAreStored) {
  {
    RawlogWriter out(log);
    for (int i = 0; i < 20; ++i) {
      auto o = imageObservation(0.1 * i);
      o.image.setExternalStorage("nowhere.png");
      out.write(o);
      out.write(featuresObservation(0.1 * i, 3, Pose3::translation(2, 0, 0)));
    }
  }
  EXPECT_EQ(finding(inspect(), "image files are missing").severity, Severity::kWarning);
}

TEST_F(Check, ImagesInsideAGoodLogGiveNoFalseAlarms) {
  writeLog(log, {});
  const auto inspection = inspect();
  for (const char* words : {"gap", "jump", "clock", "calibration", "missing", "damaged", "null"})
    EXPECT_FALSE(hasFinding(inspection, words)) << words << "\n" << inspectionText(inspection);
}

TEST_F(Check, DamageIsAFindingAndTheRestIsInspected) {
  writeLog(log, {});
  const std::string bytes = readBytes(log);
  writeFile(log, bytes.substr(0, bytes.size() / 2));
  const auto inspection = inspect();
  EXPECT_TRUE(inspection.runnable());
  finding(inspection, "the file is damaged");
  EXPECT_GT(sensor(inspection, "lidar").count, 20U);
}

TEST_F(Check, AFileThatIsNoRawlogIsAnError) {
  EXPECT_THROW(inspect(), DataError);
  writeFile(log, "");
  EXPECT_THROW(inspect(), DataError);
  writeFile(log, "this is no rawlog at all");
  EXPECT_THROW(inspect(), DataError);
}

TEST_F(Check, ManyTagsAreToldTogether) {
  writeLog(log, {});
  auto inspection = inspect();
  inspection.images_searched = 44;
  const auto add = [&](int id, std::optional<double> size_m) {
    SurveyedTag& tag = inspection.tags.emplace_back();
    tag.id = id;
    tag.sightings = 2;
    tag.min_edge_px = 10.0 + id;
    tag.max_edge_px = 20.0 + id;
    tag.measured_size_m = size_m;
    tag.size_points = 30;
  };
  for (const int id : {1, 2, 3, 4, 7, 9, 10, 100, 101, 102, 103}) add(id, std::nullopt);
  add(586, 0.281);
  const std::string few = inspectionText(inspection);
  EXPECT_NE(few.find("    id   seen   smallest"), std::string::npos) << few;
  EXPECT_NE(few.find("   586      2     596 px     606 px   0.281 m (30 points)\n"),
            std::string::npos)
      << few;
  add(587, 0.30);
  const std::string many = inspectionText(inspection);
  EXPECT_NE(many.find("Tags seen in 44 of the images\n"
                      "13 tags, seen 26 times, edges of 11 to 607 px, 2 measured with 0.281 to "
                      "0.300 m: ids 1-4, 7, 9, 10, 100-103, 586, 587\n"),
            std::string::npos)
      << many;
  EXPECT_EQ(many.find("    id   seen"), std::string::npos) << many;
}

TEST_F(Check, TextAndJsonTellTheSame) {
  writeLog(log, {});
  const auto inspection = inspect();
  const std::string text = inspectionText(inspection);
  for (const char* word : {"lidar", "CObservationPointCloud", "dynemo-slam can run it: 51 frames"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  const auto json = nlohmann::json::parse(inspectionJson(inspection));
  EXPECT_EQ(json["runnable"], true);
  EXPECT_EQ(json["frames"], 51);
  ASSERT_EQ(json["sensors"].size(), 3U);
  EXPECT_EQ(json["sensors"][1]["label"], "lidar");
  EXPECT_EQ(json["sensors"][1]["scan"]["mean_points"], 100.0);
  EXPECT_EQ(json["findings"].size(), inspection.findings.size());
}

TEST_F(Check, AFileThatIsNoRawlogIsNotRepaired) {
  for (const auto& [content, kind] :
       std::map<std::string, std::string>{{"# A page of text\n", "it is text"},
                                          {"#ROSBAG V2.0\n\x7F\x01", "dynemo-prep import"},
                                          {"\x89PNG\r\n\x1A\n", "PNG image"},
                                          {std::string(100, '\x05'), "those of no object"}}) {
    std::ofstream(log, std::ios::binary) << content;
    try {
      inspect();
      ADD_FAILURE() << kind;
    } catch (const DataError& e) {
      EXPECT_NE(std::string(e.what()).find("is no MRPT rawlog: "), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find(kind), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace dynemo::test
