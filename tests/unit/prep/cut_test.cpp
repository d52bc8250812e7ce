// trim, split, decimate and merge.
#include <gtest/gtest.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <cmath>
#include <cstdlib>

#include "dynemo/core/error.h"
#include "dynemo/prep/rewrite.h"
#include "generated_rawlog.h"
#include "written_log.h"

namespace dynemo::test {
namespace {

class Cut : public ::testing::Test {
 protected:
  void SetUp() override { writeLog(input, {}); }
  TemporaryFolder folder;
  fs::path input = folder / "in.rawlog", output = folder / "out.rawlog";
};

TEST_F(Cut, TrimKeepsTheRangeByteByByte) {
  const auto report = trimRawlog(input, output, {.from_s = 1.0, .to_s = 2.0}, {});
  const auto before = readLog(input), after = readLog(output);
  std::vector<WrittenObservation> expected;
  for (const auto& o : before)
    if (o.stamp >= at(1.0) && o.stamp < at(2.0)) expected.push_back(o);
  ASSERT_EQ(after.size(), expected.size());
  ASSERT_EQ(after.size(), 40U);  // 20 odometry, 10 scans, 10 images
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].bytes, expected[i].bytes) << i;
  EXPECT_EQ(report.written, after.size());
  EXPECT_EQ(report.read, before.size());
}

TEST_F(Cut, TrimTakesUnixTimes) {
  trimRawlog(input, output, {.from_s = at(4.0).seconds(), .to_s = {}, .unix_time = true}, {});
  const auto after = readLog(output);
  ASSERT_FALSE(after.empty());
  EXPECT_EQ(after.front().stamp, at(4.0));
  EXPECT_EQ(after.back().stamp, at(5.0));
}

TEST_F(Cut, ALogWithoutAnyObjectIsAnError) {
  writeFile(input, std::string("\x1f\x8b\x08\x00", 4));
  const auto refusal = [](const auto& action) -> std::string {
    try {
      action();
    } catch (const DataError& e) {
      return e.what();
    }
    return "accepted";
  };
  const fs::path good = folder / "good.rawlog";
  writeLog(good, {.duration_s = 1});
  for (const std::string& what :
       {refusal([&] { decimateRawlog(input, output, {.keep_every = 2}, {}); }),
        refusal([&] { trimRawlog(input, output, {.from_s = 0.0, .to_s = 1.0}, {}); }), refusal([&] {
          mergeRawlogs({good, input}, output, {});
        })})
    EXPECT_NE(what.find("in.rawlog: holds no object: "), std::string::npos) << what;
  EXPECT_EQ(filesIn(folder / ""), (std::vector<std::string>{"good.rawlog", "in.rawlog"}));
}

TEST_F(Cut, AnEmptyResultIsAnErrorAndLeavesNothing) {
  EXPECT_THROW(trimRawlog(input, output, {.from_s = 100.0, .to_s = {}}, {}), DataError);
  EXPECT_THROW(trimRawlog(input, output, {.from_s = 2.0, .to_s = 1.0}, {}), ConfigError);
  for (const double wrong : {std::nan(""), HUGE_VAL, -1e300}) {
    EXPECT_THROW(trimRawlog(input, output, {.from_s = wrong}, {}), ConfigError) << wrong;
    EXPECT_THROW(trimRawlog(input, output, {.to_s = wrong}, {}), ConfigError) << wrong;
  }
  try {
    trimRawlog(input, output, {.from_s = at(0.0).seconds()}, {});
    ADD_FAILURE() << "UNIX time was taken for seconds after the beginning";
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find(" s from " + at(0.0).text()), std::string::npos)
        << e.what();
  }
  EXPECT_EQ(filesIn(folder / ""), std::vector<std::string>{"in.rawlog"});
}

TEST_F(Cut, ActionsStayWithTheirFrame) {
  {
    RawlogWriter out(input);
    for (int i = 0; i < 10; ++i) {
      mrpt::obs::CActionCollection actions;
      mrpt::obs::CActionRobotMovement2D action;
      action.timestamp = mrptTime(i - 0.5);
      actions.insert(action);
      out.write(actions);
      mrpt::obs::CSensoryFrame frame;
      frame.insert(std::make_shared<mrpt::obs::CObservationPointCloud>(cloudObservation(i)));
      out.write(frame);
    }
  }
  const auto report = trimRawlog(input, output, {.from_s = 3.0, .to_s = 6.0}, {});
  EXPECT_EQ(report.written, 6U);
  RawlogReader reader(output, std::size_t{1} << 30);
  for (int i = 3; i < 6; ++i) {
    EXPECT_EQ(reader.next()->class_name, "CActionCollection");
    const auto entry = reader.next();
    const auto& frame = dynamic_cast<const mrpt::obs::CSensoryFrame&>(*entry->object);
    EXPECT_EQ(validStamp((*frame.begin())->timestamp), at(i));
  }
  EXPECT_FALSE(reader.next());
}

TEST_F(Cut, SplitPartsMakeUpTheWhole) {
  const auto report = splitRawlog(input, output, 2.0, {});
  ASSERT_EQ(report.files.size(), 3U);
  EXPECT_EQ(report.files[0].filename(), "out_01.rawlog");
  std::string all;
  for (const auto& file : report.files) all += readBytes(file);
  EXPECT_EQ(all, readBytes(input));
  EXPECT_EQ(readLog(report.files[1]).front().stamp, at(2.0));
}

TEST_F(Cut, TooManyPartsAreRefusedAndLeaveNothing) {
  EXPECT_THROW(splitRawlog(input, output, 0.001, {}), ConfigError);
  for (const double wrong : {0.0, 1e-12, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(splitRawlog(input, output, wrong, {}), ConfigError) << wrong;
  EXPECT_EQ(filesIn(folder / ""), std::vector<std::string>{"in.rawlog"});
}

TEST_F(Cut, DecimateThinsObservationsOfChosenSensors) {
  decimateRawlog(input, output, {.labels = {"lidar"}, .keep_every = 2}, {});
  const auto before = countByLabel(readLog(input)), after = countByLabel(readLog(output));
  EXPECT_EQ(before.at("lidar"), 51);
  EXPECT_EQ(after.at("lidar"), 26);
  EXPECT_EQ(after.at("camera"), before.at("camera"));
  EXPECT_EQ(after.at("odom3d"), before.at("odom3d"));
}

TEST_F(Cut, DecimateThinsPoints) {
  decimateRawlog(input, output, {.labels = {}, .keep_every = 1, .keep_points_every = 3}, {});
  for (const auto& o : readLog(output)) {
    const auto* cloud = dynamic_cast<mrpt::obs::CObservationPointCloud*>(o.object.get());
    if (cloud) {
      EXPECT_EQ(cloud->pointcloud->size(), 34U);
    }
  }
}

TEST_F(Cut, AnUnknownLabelIsRefusedAndTheKnownOnesAreNamed) {
  try {
    decimateRawlog(input, output, {.labels = {"lidar", "nope"}, .keep_every = 2}, {});
    FAIL();
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("'nope'; it has 'camera', 'lidar', 'odom3d'"),
              std::string::npos)
        << e.what();
  }
  EXPECT_FALSE(fs::exists(output));
}

TEST_F(Cut, MergeOrdersByTime) {
  // Two sensors in files of their own, and a third recorded later.
  writeLog(folder / "a.rawlog", {.image_period_s = 0, .odometry_period_s = 0});
  writeLog(folder / "b.rawlog", {.scan_period_s = 0, .image_period_s = 0});
  const auto report = mergeRawlogs({folder / "a.rawlog", folder / "b.rawlog"}, output, {});
  const auto merged = readLog(output);
  EXPECT_EQ(report.written, 51U + 101U);
  EXPECT_EQ(countByLabel(merged), (std::map<std::string, int>{{"lidar", 51}, {"odom3d", 101}}));
  for (std::size_t i = 1; i < merged.size(); ++i)
    EXPECT_LE(merged[i - 1].stamp, merged[i].stamp) << i;
  EXPECT_TRUE(report.warnings.empty());
}

TEST_F(Cut, MergeWarnsOfSensorsWithTheSameName) {
  const auto report = mergeRawlogs({input, input}, output, {});
  EXPECT_EQ(report.warnings.size(), 3U);
  EXPECT_NE(report.warnings.begin()->first.find("several inputs"), std::string::npos);
  // Parts of one recording are no reason to warn.
  const auto parts = splitRawlog(input, folder / "part.rawlog", 2.5, {});
  EXPECT_TRUE(mergeRawlogs(parts.files, folder / "whole.rawlog", {}).warnings.empty());
  EXPECT_EQ(readBytes(folder / "whole.rawlog"), readBytes(input));
}

TEST_F(Cut, MergeRefusesActionsAndFrames) {
  {
    RawlogWriter out(folder / "frames.rawlog");
    out.write(mrpt::obs::CActionCollection());
    out.write(mrpt::obs::CSensoryFrame());
  }
  EXPECT_THROW(mergeRawlogs({input, folder / "frames.rawlog"}, output, {}), DataError);
  EXPECT_FALSE(fs::exists(output));
}

TEST_F(Cut, CompressionFollowsTheInputUnlessAsked) {
  trimRawlog(input, output, {}, {});
  EXPECT_EQ(readBytes(output), readBytes(input));
  trimRawlog(input, folder / "gz.rawlog", {}, {.compressed = true});
  EXPECT_LT(fs::file_size(folder / "gz.rawlog"), fs::file_size(input));
  EXPECT_EQ(readLog(folder / "gz.rawlog").size(), readLog(input).size());
  trimRawlog(folder / "gz.rawlog", folder / "plain.rawlog", {}, {.compressed = false});
  EXPECT_EQ(readBytes(folder / "plain.rawlog"), readBytes(input));
}

TEST_F(Cut, DamageIsAWarningAndWhatCameBeforeIsKept) {
  const std::string bytes = readBytes(input);
  writeFile(folder / "cut.rawlog", bytes.substr(0, bytes.size() / 2));
  const auto report = trimRawlog(folder / "cut.rawlog", output, {}, {});
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_NE(report.warnings.begin()->first.find("damaged"), std::string::npos);
  const auto kept = readBytes(output);
  EXPECT_GT(kept.size(), bytes.size() / 2 - 20000);
  EXPECT_EQ(kept, bytes.substr(0, kept.size()));
}

TEST_F(Cut, NullObjectsAreLeftOut) {
  {
    RawlogWriter out(folder / "null.rawlog");
    out.write(poseObservation(0.0));
    out.writeNull();
    out.write(poseObservation(0.1));
  }
  const auto report = trimRawlog(folder / "null.rawlog", output, {}, {});
  EXPECT_EQ(report.warnings.at("stored null object left out"), 1U);
  EXPECT_EQ(readLog(output).size(), 2U);
}

}  // namespace
}  // namespace dynemo::test
