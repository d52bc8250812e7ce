// Input that is wrong in every way we could think of: one clear error or a counted warning, never a
// crash.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <sys/resource.h>

#include <cstring>
#include <limits>
#include <random>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/rawlog_source.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kLimitsMemory = false;  // AddressSanitizer ends the process on a failed allocation
#else
constexpr bool kLimitsMemory = true;
#endif

long peakMemory_kB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Replaces the last occurrence of `before` by `after`.
void patchLast(std::string& bytes, const std::string& before, const std::string& after) {
  const auto found = bytes.rfind(before);
  ASSERT_NE(found, std::string::npos);
  bytes.replace(found, before.size(), after);
}

std::string littleEndian(std::uint32_t value) {
  std::string bytes(4, '\0');
  std::memcpy(bytes.data(), &value, 4);
  return bytes;
}

std::string serialised(const mrpt::serialization::CSerializable& object) {
  TemporaryFolder folder;
  RawlogWriter(folder / "object").write(object);
  return readBytes(folder / "object");
}

class BadInput : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  const fs::path log_ = folder_ / "log.rawlog";
  IngestParams params_;
  IngestReport report_;

  std::vector<SensorFrame> frames() {
    const auto source = makeRawlogSource(params_, log_);
    auto all = allFrames(*source);
    report_ = source->report();
    return all;
  }
  std::string error() {
    try {
      frames();
    } catch (const DataError& e) {
      return e.what();
    }
    return "no error";
  }
  /// A good log whose bytes are `bytes`.
  std::string goodBytes(bool compressed = false) {
    writeLog(log_, {.duration_s = 1.0, .compressed = compressed});
    return readBytes(log_);
  }
};

TEST_F(BadInput, MissingFile) {
  EXPECT_NE(error().find("log.rawlog: no such file"), std::string::npos) << error();
}

TEST_F(BadInput, EmptyFile) {
  writeFile(log_, "");
  EXPECT_NE(error().find("is empty"), std::string::npos) << error();
}

TEST_F(BadInput, Folder) {
  fs::create_directory(log_);
  EXPECT_NE(error().find("is a folder"), std::string::npos) << error();
}

TEST_F(BadInput, RandomBytes) {
  std::mt19937 random(1);
  for (int run = 0; run < 50; ++run) {
    std::string bytes(1 + random() % 5000, '\0');
    for (char& b : bytes) b = static_cast<char>(random());
    if (run % 3 == 1) bytes.replace(0, 2, "\x1f\x8b");                // looks compressed
    if (run % 3 == 2) bytes[0] = static_cast<char>(0x80 | bytes[0]);  // looks like an object
    writeFile(log_, bytes);
    const std::string said = error();
    EXPECT_TRUE(said.find("no usable") != std::string::npos ||
                said.find("is no MRPT rawlog") != std::string::npos)
        << said;
  }
}

TEST_F(BadInput, LogWithoutAnyKnownSensorNamesWhatItHolds) {
  {
    RawlogWriter out(log_);
    mrpt::obs::CObservationComment comment;
    comment.timestamp = mrptTime(0);
    out.write(comment);
  }
  EXPECT_NE(error().find("1 of (no label) (CObservationComment)"), std::string::npos) << error();
}

TEST_F(BadInput, TruncatedFileGivesWhatItHas) {
  for (const bool compressed : {false, true}) {
    const std::string bytes = goodBytes(compressed);
    writeFile(log_, bytes.substr(0, bytes.size() / 2));
    const auto all = frames();
    EXPECT_GE(all.size(), 2U) << compressed;  // the beginning compresses worst
    EXPECT_LE(all.size(), 7U) << compressed;
    EXPECT_EQ(warningCount(report_, "rawlog damaged, the rest is not used"), 1U) << compressed;
    EXPECT_EQ(warningCount(report_, "near byte"), 1U) << "says where";
  }
}

TEST_F(BadInput, TruncatedAtEveryByteOfAnObject) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 12; ++i) out.write(cloudObservation(0.1 * i, 3));
  }
  const std::string bytes = readBytes(log_);
  const std::size_t object = bytes.size() / 12;
  ASSERT_EQ(object * 12, bytes.size());
  for (std::size_t cut = 0; cut <= object; ++cut) {
    writeFile(log_, bytes.substr(0, bytes.size() - cut));
    const std::size_t complete = cut == 0 ? 12 : 11;
    EXPECT_EQ(frames().size(), complete) << cut;
    const bool between_objects = cut == 0 || cut == object;
    EXPECT_EQ(warningCount(report_, "damaged"), between_objects ? 0U : 1U) << cut;
  }
}

TEST_F(BadInput, CompressedFileCutAfterTheLastObjectIsReported) {
  const std::string bytes = goodBytes(true);
  writeFile(log_, bytes.substr(0, bytes.size() - 4));
  EXPECT_EQ(frames().size(), 11U);
  EXPECT_EQ(warningCount(report_, "the compressed data is incomplete"), 1U);
}

TEST_F(BadInput, SeveralCompressedMembersAreOneLog) {
  writeLog(log_, {.duration_s = 0.9, .compressed = true});
  std::string bytes = readBytes(log_);
  {
    RawlogWriter out(log_, true);
    for (int i = 10; i < 20; ++i) out.write(cloudObservation(0.1 * i));
  }
  writeFile(log_, bytes + readBytes(log_) + std::string("trailing rubbish"));
  EXPECT_EQ(frames().size(), 20U);
  EXPECT_EQ(warningCount(report_, "damaged"), 0U);
}

TEST_F(BadInput, CompressedFileWithWrongChecksumIsReported) {
  std::string bytes = goodBytes(true);
  bytes[bytes.size() - 6] = static_cast<char>(bytes[bytes.size() - 6] ^ 0x5A);
  writeFile(log_, bytes);
  EXPECT_GE(frames().size(), 10U);
  EXPECT_EQ(warningCount(report_, "damaged"), 1U);
}

TEST_F(BadInput, StoredNullObjectsAreSkipped) {
  {
    RawlogWriter out(log_);
    out.writeNull();
    for (int i = 0; i < 20; ++i) {
      out.write(cloudObservation(0.1 * i));
      if (i == 10) out.writeNull();
    }
    mrpt::obs::CSensoryFrame frame;
    for (const double t : {2.0, 2.1})
      frame.insert(std::make_shared<mrpt::obs::CObservationPointCloud>(cloudObservation(t)));
    out.write(frame);
  }
  // MRPT refuses to write a null object into a sensory frame, but reads one.
  std::string bytes = readBytes(log_);
  patchLast(bytes, serialised(cloudObservation(2.1)), "\x87nullptr\x88");
  writeFile(log_, bytes);
  EXPECT_EQ(frames().size(), 21U);
  EXPECT_EQ(warningCount(report_, "stored null object skipped"), 3U);
}

TEST_F(BadInput, UnknownClassEndsTheLogWithItsName) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 20; ++i) out.write(cloudObservation(0.1 * i));
    const std::string name = "vendor::CObservationSonar";
    out.writeBytes(static_cast<char>(0x80 | name.size()) + name + '\x01' + "payload\x88");
    for (int i = 20; i < 40; ++i) out.write(cloudObservation(0.1 * i));
  }
  EXPECT_EQ(frames().size(), 20U);
  EXPECT_EQ(warningCount(report_, "unknown class 'vendor::CObservationSonar'"), 1U);
}

TEST_F(BadInput, ExtraObjectsOfOtherKindsAreSkipped) {
  {
    RawlogWriter out(log_);
    out.write(mrpt::maps::CSimplePointsMap());
    for (int i = 0; i < 5; ++i) out.write(cloudObservation(0.1 * i));
  }
  EXPECT_EQ(frames().size(), 5U);
  EXPECT_EQ(warningCount(report_, "object of class CSimplePointsMap skipped"), 1U);
}

TEST_F(BadInput, LengthBombsNeitherCrashNorFillTheMemory) {
  if (!kLimitsMemory) GTEST_SKIP() << "not under AddressSanitizer";
  constexpr std::uint32_t kPoints = 0x1234;
  for (const std::uint32_t bomb : {0xFFFFFFFFU, 0x7FFFFFFFU, 0x20000000U, 0x08000000U}) {
    {
      RawlogWriter out(log_);
      for (int i = 0; i < 20; ++i) out.write(cloudObservation(0.1 * i));
      out.write(cloudObservation(2.0, kPoints));
    }
    std::string bytes = readBytes(log_);
    patchLast(bytes, littleEndian(kPoints), littleEndian(bomb));
    writeFile(log_, bytes);
    const long before_kB = peakMemory_kB();
    EXPECT_EQ(frames().size(), 20U);
    EXPECT_EQ(warningCount(report_, "damaged"), 1U);
    EXPECT_LT(peakMemory_kB() - before_kB, 600'000) << bomb;
  }
}

TEST_F(BadInput, LengthBombInALabel) {
  if (!kLimitsMemory) GTEST_SKIP() << "not under AddressSanitizer";
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 20; ++i) out.write(cloudObservation(0.1 * i));
  }
  std::string bytes = readBytes(log_);
  patchLast(bytes, littleEndian(5) + "lidar", littleEndian(0xF0000000U) + "lidar");
  writeFile(log_, bytes);
  EXPECT_EQ(frames().size(), 19U);
  EXPECT_EQ(warningCount(report_, "asks for more memory than allowed"), 1U);
}

TEST_F(BadInput, LengthBombInAMatrix) {
  if (!kLimitsMemory) GTEST_SKIP() << "not under AddressSanitizer";
  mrpt::obs::CObservationRotatingScan scan;
  scan.timestamp = mrptTime(2.0);
  scan.rowCount = 0x0102;
  scan.columnCount = 0x0304;
  scan.rangeResolution = 0.01;
  scan.rangeImage.setZero(scan.rowCount, scan.columnCount);
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 20; ++i) out.write(cloudObservation(0.1 * i));
    out.write(scan);
  }
  std::string bytes = readBytes(log_);
  patchLast(bytes, std::string("\x04\x03\x02\x01", 4), "\xFF\xFF\xFF\xFF");
  writeFile(log_, bytes);
  EXPECT_EQ(frames().size(), 20U);
  EXPECT_EQ(warningCount(report_, "damaged"), 1U);
}

// Flipped bits anywhere: either frames come out, in order, or one error.
class Mutated : public BadInput, public ::testing::WithParamInterface<bool> {};

TEST_P(Mutated, NeverCrash) {
  if (!kLimitsMemory)
    GTEST_SKIP() << "not under AddressSanitizer: a flipped length fills the memory";
  const bool compressed = GetParam();
  {
    RawlogWriter out(log_, compressed);
    for (int i = 0; i < 12; ++i) {
      out.write(poseObservation(0.1 * i));
      out.write(cloudObservation(0.1 * i, 20));
      if (i % 4 == 0) out.write(imageObservation(0.1 * i));
      out.write(odometryObservation(0.1 * i));
      out.write(featuresObservation(0.1 * i, 3, Pose3()));
    }
  }
  const std::string good = readBytes(log_);
  constexpr int kRuns = 300;
  int with_frames = 0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    std::mt19937 random(seed);
    std::string bytes = good;
    const unsigned flips = 1 + random() % 8;
    for (unsigned i = 0; i < flips; ++i) {
      const auto bit = random() % 8;
      char& byte = bytes[random() % bytes.size()];
      byte = static_cast<char>(byte ^ (1U << bit));
    }
    writeFile(log_, bytes);
    try {
      std::optional<Stamp> last;
      for (const SensorFrame& f : frames()) {
        EXPECT_TRUE(!last || *last < f.stamp) << "seed " << seed;
        last = f.stamp;
        EXPECT_TRUE(!f.odometry || f.odometry->T_odom_base.isFinite()) << "seed " << seed;
      }
      ++with_frames;
    } catch (const DataError&) {
    } catch (const ConfigError&) {  // a flipped label looks like a second sensor
    }
  }
  EXPECT_GT(with_frames, kRuns / 4);
}

INSTANTIATE_TEST_SUITE_P(Formats, Mutated, ::testing::Bool(),
                         [](const auto& format) { return format.param ? "Compressed" : "Plain"; });

// Observations that read well and hold nonsense.

TEST_F(BadInput, PointsThatAreNotFiniteOrOutOfRangeAreRemoved) {
  params_.lidar.max_range_m = 20;
  params_.lidar.min_range_m = 1;
  auto o = cloudObservation(0.0, 10);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  o.pointcloud->insertPoint(nan, 0, 0);
  o.pointcloud->insertPoint(0, std::numeric_limits<float>::infinity(), 0);
  o.pointcloud->insertPoint(30, 0, 0);
  o.pointcloud->insertPoint(0, 0.5F, 0);
  RawlogWriter(log_).write(o);
  const auto all = frames();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].scan->cloud.size(), 10U);
  EXPECT_EQ(warningCount(report_, "not finite removed"), 2U);
  EXPECT_EQ(warningCount(report_, "out of range removed"), 2U);
}

TEST_F(BadInput, EmptyCloudsAndCloudsOfNaNLeaveTheRestOfTheFrame) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 10; ++i) {
      auto o = cloudObservation(0.1 * i, i == 4 ? 0 : 10);
      if (i == 5) o.pointcloud.reset();
      if (i == 6) {
        o.pointcloud->clear();
        o.pointcloud->insertPoint(std::numeric_limits<float>::quiet_NaN(), 0, 0);
      }
      out.write(o);
      out.write(imageObservation(0.1 * i));
    }
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(all[i].scan.has_value(), i < 4 || i > 6) << i;
    EXPECT_EQ(all[i].images.size(), 1U) << i;
  }
  EXPECT_EQ(warningCount(report_, "the cloud is empty"), 2U);
  EXPECT_EQ(warningCount(report_, "has no cloud"), 1U);
}

TEST_F(BadInput, OnlyEmptyCloudsIsAnError) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 10; ++i) out.write(cloudObservation(0.1 * i, 0));
  }
  EXPECT_NE(error().find("the cloud is empty (10x)"), std::string::npos) << error();
}

TEST_F(BadInput, MissingImageFilesAreCountedAndTheFirstIsNamed) {
  fs::create_directory(folder_ / "log_Images");
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 10; ++i) {
      out.write(cloudObservation(0.1 * i));
      auto image = imageObservation(0.1 * i);
      const std::string name = "image_" + std::to_string(i) + ".png";
      if (i % 2 == 0) image.image.saveToFile(folder_ / "log_Images" / name);
      image.image.setExternalStorage(name);
      out.write(image);
    }
  }
  writeFile(folder_ / "log_Images" / "image_4.png", "not an image");
  const auto all = frames();
  ASSERT_EQ(all.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i)
    EXPECT_EQ(all[i].images.size(), i % 2 == 0 && i != 4 ? 1U : 0U) << i;
  EXPECT_EQ(warningCount(report_, "image file not found (first: image_1.png)"), 5U);
  EXPECT_EQ(warningCount(report_, "image file cannot be read (first: image_4.png)"), 1U);
}

TEST_F(BadInput, PosesThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 10; ++i) {
      auto pose = poseObservation(0.1 * i);
      if (i == 3) pose.pose.mean = mrpt::poses::CPose3D(nan, 0, 0, 0, 0, 0);
      out.write(pose);
      auto cloud = cloudObservation(0.1 * i);
      if (i == 5) cloud.sensorPose = mrpt::poses::CPose3D(0, 0, nan, 0, 0, 0);
      out.write(cloud);
      out.write(featuresObservation(0.1 * i, i == 7 ? -1 : 4, Pose3()));
    }
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 10U);
  ASSERT_TRUE(all[3].odometry);
  EXPECT_TRUE(all[3].odometry->T_odom_base.isFinite());
  EXPECT_FALSE(all[5].scan);
  EXPECT_TRUE(all[7].detections.empty());
  EXPECT_EQ(warningCount(report_, "the pose is not plausible"), 1U);
  EXPECT_EQ(warningCount(report_, "the sensor pose is not plausible"), 1U);
  EXPECT_EQ(warningCount(report_, "without id"), 1U);
}

TEST_F(BadInput, ObservationsWithoutStampAreCounted) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 10; ++i) {
      auto cloud = cloudObservation(0.1 * i);
      if (i == 2) cloud.timestamp = INVALID_TIMESTAMP;
      if (i == 3)
        cloud.timestamp = mrpt::Clock::time_point(
            mrpt::Clock::duration(std::numeric_limits<mrpt::Clock::rep>::max()));
      if (i == 4)
        cloud.timestamp = mrpt::Clock::time_point(
            mrpt::Clock::duration(std::numeric_limits<mrpt::Clock::rep>::min()));
      out.write(cloud);
    }
  }
  EXPECT_EQ(frames().size(), 7U);
  EXPECT_EQ(warningCount(report_, "without valid time stamp"), 3U);
}

TEST_F(BadInput, RepeatedStampsGiveOneFrame) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 1000; ++i) out.write(cloudObservation(1.0, 3));
  }
  EXPECT_EQ(frames().size(), 1U);
  EXPECT_EQ(warningCount(report_, "repeated stamp"), 999U);
}

TEST_F(BadInput, SingleStampsFarOffAreDropped) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 100; ++i) {
      double t = 0.1 * i;
      if (i == 40) t += 1e6;
      if (i == 60) t -= 1e6;
      out.write(cloudObservation(t, 3));
    }
  }
  EXPECT_EQ(frames().size(), 98U);
  EXPECT_EQ(warningCount(report_, "far ahead"), 1U);
  EXPECT_EQ(warningCount(report_, "runs backwards"), 1U);
}

TEST_F(BadInput, AClockThatIsSetBackLosesNothing) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 200; ++i) {
      const double t = i < 100 ? 1000 + 0.1 * i : 0.1 * i;
      out.write(poseObservation(t));
      out.write(cloudObservation(t, 3));
    }
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 200U);
  for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LT(all[i - 1].stamp, all[i].stamp);
  EXPECT_NEAR(secondsBetween(all[120].stamp, all[121].stamp), 0.1, 1e-9);
  EXPECT_EQ(warningCount(report_, "clock set back"), 1U);
}

TEST_F(BadInput, AClockThatJumpsForwardsIsFollowed) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 200; ++i)
      out.write(cloudObservation(i < 100 ? 0.1 * i : 5000 + 0.1 * i, 3));
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 200U);
  EXPECT_EQ(all[150].stamp, at(5015));
  EXPECT_EQ(warningCount(report_, "jump forwards"), 1U);
}

TEST_F(BadInput, StampsThatAlwaysRunBackwardsStillEnd) {
  {
    RawlogWriter out(log_);
    for (int i = 0; i < 500; ++i) out.write(cloudObservation(1000.0 - i, 3));
  }
  const auto all = frames();
  EXPECT_GE(all.size(), 1U);
  for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LT(all[i - 1].stamp, all[i].stamp);
  EXPECT_EQ(all.size() + warningCount(report_, "runs backwards") +
                warningCount(report_, "observation dropped") -
                warningCount(report_, "runs backwards beyond the window, observation dropped"),
            500U);
}

TEST_F(BadInput, WrongParametersAreNamed) {
  writeLog(log_, {.duration_s = 0.5});
  params_.extrinsics["lidar"] = {1, 2, 3};
  params_.extrinsics["camera"] = {0, 0, 0, 0, 0, 0, 0};
  try {
    frames();
    FAIL() << "wrong extrinsics accepted";
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("extrinsics.lidar"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("extrinsics.camera"), std::string::npos);
  }
}

}  // namespace
}  // namespace dynemo
