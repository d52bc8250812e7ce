// Bags written for the purpose, read back from the rawlog.
#include <gtest/gtest.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "bag_writer.h"
#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/rawlog_reader.h"
#include "dynemo/rosbag/rosbag_import.h"
#include "generated_rawlog.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-9;
const std::array<double, 4> kNoRotation = {0, 0, 0, 1};
/// A quarter turn about z.
const std::array<double, 4> kQuarter = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};

class Import : public ::testing::Test {
 protected:
  RosbagImportReport import(const RosbagImportParams& params = {}) {
    return importRosbag(bag, folder / "out.rawlog", params);
  }
  /// The first observation with the label.
  template <class Observation>
  std::shared_ptr<Observation> first(const std::string& label) {
    RawlogReader reader(folder / "out.rawlog", std::size_t{1} << 30);
    while (auto entry = reader.next()) {
      auto o = std::dynamic_pointer_cast<Observation>(entry->object);
      if (o && o->sensorLabel == label) return o;
    }
    throw std::out_of_range(label);
  }
  static bool warns(const RosbagImportReport& report, const std::string& words) {
    for (const auto& [what, count] : report.warnings)
      if (what.find(words) != std::string::npos) return true;
    return false;
  }
  TemporaryFolder folder;
  fs::path bag = folder / "in.bag";
};

TEST_F(Import, CloudsKeepPointsIntensitiesAndStamps) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  {
    BagWriter out(bag);
    out.cloud("/front/points", 100.5, "lidar", {{1, 2, 3}, {nan, 0, 0}, {4, 5, 6}}, {7, 8, 9});
    out.cloud("/rear/points", 0.0, "lidar", {{1, 1, 1}}, {});
  }
  const auto report = import();
  const auto front = first<mrpt::obs::CObservationPointCloud>("front_points");
  const auto* points = dynamic_cast<mrpt::maps::CPointsMapXYZI*>(front->pointcloud.get());
  ASSERT_NE(points, nullptr);
  ASSERT_EQ(points->size(), 2U);
  float x = 0, y = 0, z = 0;
  points->getPoint(1, x, y, z);
  EXPECT_EQ((std::array<float, 3>{x, y, z}), (std::array<float, 3>{4, 5, 6}));
  EXPECT_EQ(points->getPointIntensity(0), 7.0F);
  EXPECT_EQ(points->getPointIntensity(1), 9.0F);
  EXPECT_EQ(fromMrpt(front->timestamp), Stamp::fromSeconds(100.5));
  // Without a stamp of its own, a message counts from its reception.
  EXPECT_EQ(fromMrpt(first<mrpt::obs::CObservationPointCloud>("rear_points")->timestamp),
            Stamp::fromSeconds(100.25));
  EXPECT_TRUE(warns(report, "not finite"));
  EXPECT_TRUE(warns(report, "robot's origin"));
}

TEST_F(Import, TimesPerPointAreMissedByWhateverNameTheyHave) {
  const auto missed = [this](const char* name) {
    { BagWriter(bag).cloud("/points", 100, "/lidar", {{1, 1, 1}}, {}, name); }
    fs::remove(folder / "out.rawlog");
    return warns(import(), "times per point");
  };
  for (const char* name : {"t", "time", "timestamp", "offset_time", "time_sec"})
    EXPECT_TRUE(missed(name)) << name;
  EXPECT_FALSE(missed(nullptr));
}

TEST_F(Import, MountingComesFromTf) {
  {
    BagWriter out(bag);
    out.transform("/tf_static", 99, "base_link", "mast", {1, 0, 0}, kQuarter);
    out.transform("/tf_static", 99, "mast", "lidar", {2, 0, 0}, kNoRotation);
    // The robot's own motion is above what both have in common.
    out.transform("/tf", 100, "odom", "base_link", {5, 5, 0}, kNoRotation);
    out.transform("/tf", 101, "odom", "base_link", {9, 5, 0}, kNoRotation);
    out.cloud("/points", 100, "/lidar", {{1, 1, 1}}, {});
  }
  const auto report = import();
  EXPECT_EQ(report.base_frame, "base_link");
  EXPECT_TRUE(report.warnings.empty()) << report.warnings.begin()->first;
  const Pose3 T = fromMrpt(first<mrpt::obs::CObservationPointCloud>("points")->sensorPose);
  EXPECT_LT((T.t - Vector3(1, 2, 0)).norm(), kTolerance);
  EXPECT_LT((T.R.col(0) - Vector3(0, 1, 0)).norm(), kTolerance);
}

TEST_F(Import, SensorsThatMoveAgainstTheRobotAreNamed) {
  {
    BagWriter out(bag);
    out.transform("/tf", 100, "base_link", "lidar", {1, 0, 0}, kNoRotation);
    out.transform("/tf", 101, "base_link", "lidar", {2, 0, 0}, kNoRotation);
    out.cloud("/points", 100, "lidar", {{1, 1, 1}}, {});
  }
  EXPECT_TRUE(warns(import(), "moves against the robot"));
}

TEST_F(Import, ImagesBecomeFilesWithCalibration) {
  std::vector<std::uint8_t> rgb(64 * 48 * 3);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(i % 251);
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC1, cv::Scalar(90)), jpeg);
  {
    BagWriter out(bag);
    out.cameraInfo("/cam/camera_info", 100, 64, 48, "equidistant", {0.1, 0.2, 0.3, 0.4});
    out.image("/cam/image_raw", 100, "camera", "rgb8", 64, 48, rgb);
    out.image("/cam/image_rect", 100, "camera", "mono8", 64, 48,
              std::vector<std::uint8_t>(64 * 48));
    out.compressedImage("/cam/image_raw/compressed", 100, "camera", jpeg);
    out.compressedImage("/cam/other/compressed", 100, "camera", {1, 2, 3, 4});
    out.image("/cam/odd", 100, "camera", "64FC7", 64, 48, std::vector<std::uint8_t>(64 * 48));
    out.image("/cam/short", 100, "camera", "bgr8", 64, 48, std::vector<std::uint8_t>(64 * 48));
  }
  const auto report = import();
  const auto raw = first<mrpt::obs::CObservationImage>("cam_image_raw");
  EXPECT_EQ(raw->cameraParams.fx(), 60.0);
  EXPECT_EQ(raw->cameraParams.k4(), 0.4);
  EXPECT_EQ(raw->cameraParams.distortion, mrpt::img::DistortionModel::kannala_brandt);
  const cv::Mat pixels = cv::imread(
      (folder / "out_Images" / raw->image.getExternalStorageFile()).string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(pixels.type(), CV_8UC3);
  EXPECT_EQ(pixels.at<cv::Vec3b>(0, 0), cv::Vec3b(rgb[2], rgb[1], rgb[0]));
  const auto rectified = first<mrpt::obs::CObservationImage>("cam_image_rect");
  EXPECT_EQ(rectified->cameraParams.fx(), 70.0);
  EXPECT_EQ(rectified->cameraParams.distortion, mrpt::img::DistortionModel::none);
  const auto compressed = first<mrpt::obs::CObservationImage>("cam_image_raw_compressed");
  EXPECT_EQ(compressed->cameraParams.fx(), 60.0);
  EXPECT_EQ(readBytes(folder / "out_Images" / compressed->image.getExternalStorageFile()),
            std::string(jpeg.begin(), jpeg.end()));
  EXPECT_TRUE(warns(report, "neither JPEG nor PNG"));
  EXPECT_TRUE(warns(report, "64FC7"));
  EXPECT_TRUE(warns(report, "shorter than its description"));
  EXPECT_EQ(report.written.size(), 3U);
}

TEST_F(Import, OdometryIsThatOfTheBaseWithItsCovariance) {
  std::array<double, 36> covariance{};
  for (std::size_t i = 0; i < 6; ++i)
    covariance[i * 7] = i < 3 ? 0.01 * static_cast<double>(i + 1) : 0.001;
  {
    BagWriter out(bag);
    out.transform("/tf_static", 99, "imu", "base_link", {0, 0, -1}, kNoRotation);
    out.odometry("/odom", 100, "imu", {3, 4, 5}, kQuarter, covariance);
    out.odometry("/plain", 100, "base_link", {3, 4, 5}, kNoRotation, {});
  }
  import();
  const auto o = first<mrpt::obs::CObservationRobotPose>("odom");
  const Pose3 T = fromMrpt(o->pose.mean);
  EXPECT_LT((T.t - Vector3(3, 4, 4)).norm(), kTolerance);
  EXPECT_LT((T.R.col(0) - Vector3(0, 1, 0)).norm(), kTolerance);
  const Matrix6 tangent = covarianceFromMrpt(T, o->pose.cov);
  // The base lies 1 m under what was measured: rotations about x and y move it. In its own axes
  // the odometry's y is x and its −x is y.
  EXPECT_NEAR(tangent(0, 0), 0.02 + 0.001, 1e-9);
  EXPECT_NEAR(tangent(1, 1), 0.01 + 0.001, 1e-9);
  EXPECT_NEAR(tangent(2, 2), 0.03, 1e-9);
  EXPECT_NEAR(tangent(5, 5), 0.001, 1e-9);
  EXPECT_TRUE(first<mrpt::obs::CObservationRobotPose>("plain")->pose.cov.asEigen().isZero(0.0));
}

TEST_F(Import, TopicsCanBeChosenAndNamed) {
  {
    BagWriter out(bag);
    out.cloud("/a", 100, "lidar", {{1, 1, 1}}, {});
    out.cloud("/b", 100, "lidar", {{1, 1, 1}}, {});
  }
  RosbagImportParams params;
  params.labels = {{"/b", "lidar"}};
  const auto report = import(params);
  EXPECT_EQ(report.written,
            (std::map<std::string, std::uint64_t>{{"lidar (CObservationPointCloud)", 1}}));
  EXPECT_EQ(report.left_out,
            (std::map<std::string, std::uint64_t>{{"/a (sensor_msgs/PointCloud2)", 1}}));
  params.base_frame = "nowhere";
  EXPECT_THROW(importRosbag(bag, folder / "other.rawlog", params), ConfigError);
}

TEST_F(Import, WhatCannotBeUsedIsOneError) {
  EXPECT_THROW(import(), DataError);
  fs::create_directory(bag);
  try {
    import();
    ADD_FAILURE() << "accepted a folder";
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find("folder"), std::string::npos) << e.what();
  }
  fs::remove(bag);
  writeFile(bag, "no bag at all");
  EXPECT_THROW(import(), DataError);
  {
    BagWriter out(bag);
    out.transform("/tf", 100, "a", "b", {1, 0, 0}, kNoRotation);
  }
  EXPECT_THROW(import(), DataError);
  EXPECT_FALSE(fs::exists(folder / "out.rawlog"));
}

TEST_F(Import, DamagedBagsGiveAnErrorOrACountedWarning) {
  {
    BagWriter out(bag);
    for (int i = 0; i < 50; ++i)
      out.cloud("/points", 100 + i, "lidar", std::vector<std::array<float, 3>>(500, {1, 2, 3}), {});
  }
  const std::string bytes = readBytes(bag);
  for (std::size_t k = 1; k < 20; ++k) {
    std::string damaged = bytes;
    // A stretch of wrong bytes, and another time a cut.
    const std::size_t at_byte = bytes.size() * k / 20;
    if (k % 2 == 0)
      damaged.resize(at_byte);
    else
      for (std::size_t i = at_byte; i < std::min(bytes.size(), at_byte + 64); ++i)
        damaged[i] = static_cast<char>(0x5A ^ damaged[i]);
    writeFile(bag, damaged);
    fs::remove(folder / "out.rawlog");
    try {
      import();
    } catch (const DataError& e) {
      EXPECT_NE(std::string(e.what()), "");
    }
  }
}

}  // namespace
}  // namespace dynemo::test
