// Each observation class, decoded on its own.
#include "dynemo/ingest/decoders.h"

#include <gtest/gtest.h>
#include <mrpt/maps/CColouredPointsMap.h>
#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/CWeightedPointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

constexpr float kPointTolerance_m = 1e-4F;
constexpr double kPi = std::numbers::pi;

class Decoding : public ::testing::Test {
 protected:
  IngestParams params_;
  std::map<std::string, Pose3> extrinsics_;
  ExternalFiles files_;
  WarningCounter warnings_;
  TemporaryFolder folder_;

  DecodeContext context() { return {params_, extrinsics_, files_, warnings_}; }
  Scan scan(mrpt::obs::CObservation& o) {
    const int i = decoders().scans.find(o);
    EXPECT_GE(i, 0);
    auto result = decoders().scans.entries()[static_cast<std::size_t>(i)].decode(o, context());
    EXPECT_TRUE(result) << result.error().what;
    return result ? *result : Scan{};
  }
  std::string failure(mrpt::obs::CObservation& o) {
    const int i = decoders().scans.find(o);
    auto result = decoders().scans.entries()[static_cast<std::size_t>(i)].decode(o, context());
    return result ? "no failure" : result.error().what;
  }
};

// Point clouds.

template <class Map>
class PointMaps : public Decoding {};
using Maps = ::testing::Types<mrpt::maps::CSimplePointsMap, mrpt::maps::CPointsMapXYZI,
                              mrpt::maps::CColouredPointsMap, mrpt::maps::CWeightedPointsMap>;
TYPED_TEST_SUITE(PointMaps, Maps);

TYPED_TEST(PointMaps, GiveTheirPointsInOrder) {
  mrpt::obs::CObservationPointCloud o;
  o.pointcloud = std::make_shared<TypeParam>();
  for (int i = 1; i <= 5; ++i)
    o.pointcloud->insertPoint(static_cast<float>(i), 0.5F * static_cast<float>(i), -1.0F);
  const Scan scan = this->scan(o);
  ASSERT_EQ(scan.cloud.size(), 5U);
  EXPECT_EQ(scan.cloud.points[2], Eigen::Vector3f(3, 1.5F, -1));
  EXPECT_FALSE(scan.cloud.organised());
  EXPECT_TRUE(scan.cloud.time_offset_s.empty());
}

TEST_F(Decoding, SweepRateTimesThePointsByAzimuth) {
  auto o = cloudObservation(0, 0);
  const double azimuths[] = {-kPi + 0.01, -kPi / 2, 0.0, kPi / 2, kPi - 0.01};
  for (const double a : azimuths)
    o.pointcloud->insertPoint(static_cast<float>(5 * std::cos(a)),
                              static_cast<float>(5 * std::sin(a)), 0.3F);
  params_.lidar.sweep_rate_hz = 10;
  const auto times = scan(o).cloud.time_offset_s;
  ASSERT_EQ(times.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(times[i], (azimuths[i] + kPi) / (2 * kPi) * 0.1, 1e-6) << i;
  params_.lidar.sweep_start_rad = kPi / 2;
  params_.lidar.sweep_clockwise = true;
  const auto clockwise = scan(o).cloud.time_offset_s;
  EXPECT_NEAR(clockwise[2], 0.025, 1e-6);
  EXPECT_NEAR(clockwise[1], 0.050, 1e-6);
}

TEST_F(Decoding, ExternalCloudsAreReadBesideTheLog) {
  const fs::path log = folder_ / "name.rawlog";
  fs::create_directory(folder_ / "name_Images");
  writeFile(folder_ / "name_Images" / "cloud.txt", "1 2 3\n4 5 6\n");
  files_ = ExternalFiles(log);
  mrpt::obs::CObservationPointCloud o;
  o.setAsExternalStorage("cloud.txt",
                         mrpt::obs::CObservationPointCloud::ExternalStorageFormat::PlainTextFile);
  const Scan external = scan(o);
  ASSERT_EQ(external.cloud.size(), 2U);
  EXPECT_EQ(external.cloud.points[1], Eigen::Vector3f(4, 5, 6));

  mrpt::obs::CObservationPointCloud missing;
  missing.setAsExternalStorage(
      "gone.txt", mrpt::obs::CObservationPointCloud::ExternalStorageFormat::PlainTextFile);
  EXPECT_EQ(failure(missing), "external cloud file not found");
}

// Rotating scans.

mrpt::obs::CObservationRotatingScan rotatingScan(int rows, int columns) {
  mrpt::obs::CObservationRotatingScan o;
  o.sensorLabel = "lidar";
  o.rowCount = static_cast<std::uint16_t>(rows);
  o.columnCount = static_cast<std::uint16_t>(columns);
  o.rangeResolution = 0.01;
  o.rangeImage.setZero(rows, columns);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) o.rangeImage(r, c) = 500;
  o.sweepDuration = 0.1;
  return o;
}

TEST_F(Decoding, RotatingScanUsesTheElevationTable) {
  auto o = rotatingScan(3, 8);
  o.rangeImage(1, 2) = 0;
  params_.lidar.elevations_deg = {10, 0, -20};
  const PointCloud cloud = scan(o).cloud;
  ASSERT_EQ(cloud.size(), 23U);
  EXPECT_EQ(cloud.rows, 3);
  EXPECT_EQ(cloud.columns, 8);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double e = params_.lidar.elevations_deg[cloud.row[i]] * kPi / 180;
    const double a = -kPi + 2 * kPi * cloud.column[i] / 8;
    const Eigen::Vector3f expected(static_cast<float>(5 * std::cos(e) * std::cos(a)),
                                   static_cast<float>(5 * std::cos(e) * std::sin(a)),
                                   static_cast<float>(5 * std::sin(e)));
    EXPECT_LT((cloud.points[i] - expected).norm(), kPointTolerance_m) << i;
    EXPECT_NEAR(cloud.time_offset_s[i], 0.1 * cloud.column[i] / 8, 1e-6);
  }
}

TEST_F(Decoding, RotatingScanOfPartOfATurnIncludesBothEnds) {
  auto o = rotatingScan(1, 5);
  o.startAzimuth = 0.5;
  o.azimuthSpan = -1.0;  // clockwise
  params_.lidar.elevations_deg = {0};
  const PointCloud cloud = scan(o).cloud;
  EXPECT_NEAR(std::atan2(cloud.points[0].y(), cloud.points[0].x()), 0.5, 1e-6);
  EXPECT_NEAR(std::atan2(cloud.points[4].y(), cloud.points[4].x()), -0.5, 1e-6);
}

TEST_F(Decoding, RotatingScanWithoutElevationsSaysWhatToSet) {
  auto o = rotatingScan(16, 8);
  EXPECT_NE(failure(o).find("lidar.elevations_deg must list 16"), std::string::npos) << failure(o);
}

// Velodyne packets.

/// One packet of a VLP-16 turning at 10 Hz, every return at `range_m`.
mrpt::obs::CObservationVelodyneScan::TVelodyneRawPacket velodynePacket(double azimuth_deg,
                                                                       std::uint32_t time_us,
                                                                       double range_m) {
  using Scan = mrpt::obs::CObservationVelodyneScan;
  std::string bytes(Scan::PACKET_SIZE, '\0');
  const auto put16 = [&](std::size_t at, unsigned value) {
    bytes[at] = static_cast<char>(value & 0xFF);
    bytes[at + 1] = static_cast<char>(value >> 8);
  };
  const auto units = static_cast<unsigned>(range_m / Scan::DISTANCE_RESOLUTION);
  for (std::size_t block = 0; block < Scan::BLOCKS_PER_PACKET; ++block) {
    const std::size_t start = block * 100;
    put16(start, Scan::UPPER_BANK);
    put16(start + 2, (static_cast<unsigned>(std::lround(100 * azimuth_deg)) +
                      40 * static_cast<unsigned>(block)) %
                         36000);
    for (std::size_t i = 0; i < Scan::SCANS_PER_BLOCK; ++i) put16(start + 4 + 3 * i, units);
  }
  std::memcpy(&bytes[1200], &time_us, 4);
  bytes[1204] = static_cast<char>(Scan::RETMODE_STRONGEST);
  bytes[1205] = 0x22;
  Scan::TVelodyneRawPacket packet;
  static_assert(sizeof(packet) == Scan::PACKET_SIZE);
  std::memcpy(static_cast<void*>(&packet), bytes.data(), bytes.size());
  return packet;
}

TEST_F(Decoding, VelodyneScanHasItsRangesAndTimes) {
  mrpt::obs::CObservationVelodyneScan o;
  o.timestamp = mrptTime(0);
  o.sensorLabel = "velodyne";
  o.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
  constexpr double kPacket_s = 1.327e-3;
  for (int i = 0; i < 70; ++i)
    o.scan_packets.push_back(velodynePacket(4.8 * i, static_cast<std::uint32_t>(1327 * i), 10.0));
  const PointCloud cloud = scan(o).cloud;
  EXPECT_EQ(cloud.size(), 70U * 12 * 16);  // MRPT reads one firing per block
  ASSERT_EQ(cloud.time_offset_s.size(), cloud.size());
  for (const auto& p : cloud.points) ASSERT_NEAR(p.norm(), 10.0F, 0.05F);
  EXPECT_NEAR(cloud.time_offset_s.front(), 0.0, kPacket_s);
  EXPECT_NEAR(cloud.time_offset_s.back(), 69 * kPacket_s, 2 * kPacket_s);
}

TEST_F(Decoding, VelodyneScanWithoutPackets) {
  mrpt::obs::CObservationVelodyneScan o;
  EXPECT_EQ(failure(o), "the observation has no packets");
}

// Depth cameras.

mrpt::obs::CObservation3DRangeScan depthImage(int rows, int columns, bool is_depth) {
  mrpt::obs::CObservation3DRangeScan o;
  o.hasRangeImage = true;
  o.range_is_depth = is_depth;
  o.rangeImage_setSize(rows, columns);
  o.cameraParams.nrows = static_cast<std::uint32_t>(rows);
  o.cameraParams.ncols = static_cast<std::uint32_t>(columns);
  o.cameraParams.setIntrinsicParamsFromValues(40, 41, 15.5, 11.5);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) o.rangeImage(r, c) = 2000;
  return o;
}

TEST_F(Decoding, DepthImageIsUnprojectedWithItsOwnCamera) {
  auto o = depthImage(24, 32, true);
  o.rangeImage(3, 4) = 0;
  const PointCloud cloud = scan(o).cloud;
  ASSERT_EQ(cloud.size(), 24U * 32 - 1);
  EXPECT_EQ(cloud.rows, 24);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float u = cloud.column[i], v = cloud.row[i];
    const Eigen::Vector3f expected(2, 2 * (15.5F - u) / 40, 2 * (11.5F - v) / 41);
    ASSERT_LT((cloud.points[i] - expected).norm(), kPointTolerance_m) << i;
  }
}

TEST_F(Decoding, RangesAreNotTakenForDepths) {
  auto o = depthImage(24, 32, false);
  for (const auto& p : scan(o).cloud.points) ASSERT_NEAR(p.norm(), 2.0F, 1e-3F);
}

TEST_F(Decoding, DepthImageOfAnotherSizeThanItsCalibration) {
  auto o = depthImage(24, 32, true);
  o.cameraParams.ncols = 64;
  EXPECT_NE(failure(o), "no failure");
}

TEST_F(Decoding, StoredPointsServeWithoutADepthImage) {
  mrpt::obs::CObservation3DRangeScan o;
  o.hasPoints3D = true;
  o.points3D_x = {1, 0, 3};
  o.points3D_y = {1, 0, 3};
  o.points3D_z = {1, 0, 3};
  EXPECT_EQ(scan(o).cloud.size(), 2U);
}

// Images.

TEST_F(Decoding, ImageKeepsItsCalibration) {
  auto o = imageObservation(0);
  const auto image = decodeImage(o, context());
  ASSERT_TRUE(image);
  EXPECT_EQ(image->grey.type(), CV_8UC1);
  EXPECT_EQ(image->grey.at<std::uint8_t>(3, 5), 16);
  EXPECT_EQ(image->model.width, 64);
  EXPECT_EQ(image->model.fy, 61);
  EXPECT_EQ(image->model.distortion, DistortionModel::kPlumbBob);
  EXPECT_EQ(image->model.coefficients,
            (std::array<double, 8>{0.1, -0.2, 0.001, 0.002, 0.05, 0, 0, 0}));
  EXPECT_TRUE(warnings_.counts().empty());
}

TEST_F(Decoding, ColourImageBecomesGrey) {
  auto o = imageObservation(0, "camera", 3);
  const auto image = decodeImage(o, context());
  ASSERT_TRUE(image);
  EXPECT_EQ(image->grey.type(), CV_8UC1);
  EXPECT_NEAR(image->grey.at<std::uint8_t>(10, 20), 60, 1);
}

TEST_F(Decoding, FisheyeCoefficientsAreCompacted) {
  auto o = imageObservation(0);
  o.cameraParams.setDistortionKannalaBrandt(0.1, 0.2, 0.3, 0.4);
  const auto image = decodeImage(o, context());
  ASSERT_TRUE(image);
  EXPECT_EQ(image->model.distortion, DistortionModel::kKannalaBrandt);
  EXPECT_EQ(image->model.coefficients, (std::array<double, 8>{0.1, 0.2, 0.3, 0.4, 0, 0, 0, 0}));
}

TEST_F(Decoding, ImageWithoutCalibrationIsCounted) {
  auto o = imageObservation(0);
  o.cameraParams = mrpt::img::TCamera();
  const auto image = decodeImage(o, context());
  ASSERT_TRUE(image);
  EXPECT_FALSE(image->model.valid());
  EXPECT_EQ(warnings_.counts().count("image of 'camera' without camera calibration"), 1U);
}

TEST_F(Decoding, EmptyImageFails) {
  auto o = imageObservation(0);
  o.image = mrpt::img::CImage();
  EXPECT_FALSE(decodeImage(o, context()));
}

// Odometry.

TEST_F(Decoding, RobotPoseCovarianceIsOfTheRightTangent) {
  auto o = poseObservation(3.0);
  const auto state = decodeRobotPose(o, context());
  ASSERT_TRUE(state);
  EXPECT_LT(local(truePose(3.0), state->T_odom_base).norm(), 1e-9);
  ASSERT_TRUE(state->accumulated_covariance);
  EXPECT_LT((*state->accumulated_covariance - isotropicCovariance(0.13, 0.02)).norm(), 1e-9);
  o.pose.cov.setZero();
  EXPECT_FALSE(decodeRobotPose(o, context())->accumulated_covariance);
}

}  // namespace
}  // namespace dynemo
