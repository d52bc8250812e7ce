// Small rawlogs for tests and benchmarks, written with MRPT.
#pragma once

#include <mrpt/io/CStream.h>
#include <mrpt/obs/CObservation6DFeatures.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CSerializable.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"
#include "dynemo/ingest/frame_source.h"

namespace dynemo::test {

namespace fs = std::filesystem;

/// A folder of its own for a test, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Writes objects one after the other, as CRawlog does.
class RawlogWriter {
 public:
  explicit RawlogWriter(const fs::path& file, bool compressed = false);
  void write(const mrpt::serialization::CSerializable& object);
  void writeNull();
  void writeBytes(const std::string& bytes);

 private:
  std::unique_ptr<mrpt::io::CStream> stream_;
};

/// Seconds after the beginning of the generated logs.
Stamp at(double seconds);
mrpt::Clock::time_point mrptTime(double seconds);

/// The robot drives along a circle; the pose at `seconds`.
Pose3 truePose(double seconds);
inline const Pose3 kBaseFromLidar = Pose3::fromYawPitchRoll(0.1, 0.0, 0.5, 0.2, 0.0, 0.0);
inline const Pose3 kBaseFromCamera = Pose3::fromYawPitchRoll(0.2, 0.0, 0.4, -1.57, 0.0, -1.57);

/// `points` returns on a sphere of 5 m around the sensor.
mrpt::obs::CObservationPointCloud cloudObservation(double seconds, std::size_t points = 100,
                                                   const std::string& label = "lidar");
/// A grey or colour gradient with calibration.
mrpt::obs::CObservationImage imageObservation(double seconds, const std::string& label = "camera",
                                              int channels = 1);
/// truePose(seconds) with a covariance that grows with time.
mrpt::obs::CObservationRobotPose poseObservation(double seconds,
                                                 const std::string& label = "odom3d");
mrpt::obs::CObservationOdometry odometryObservation(double seconds,
                                                    const std::string& label = "odom2d");
/// Entity `id` at T_sensor_entity.
mrpt::obs::CObservation6DFeatures featuresObservation(double seconds, int id,
                                                      const Pose3& T_sensor_entity,
                                                      const std::string& label = "detector");

struct LogShape {
  double duration_s = 5.0;
  double scan_period_s = 0.1;
  double image_period_s = 0.1;
  double odometry_period_s = 0.05;
  std::size_t points = 100;
  bool compressed = false;
};
/// Scans, images and 3-D odometry in order of time. A period of zero leaves the sensor out.
void writeLog(const fs::path& file, const LogShape& shape);

/// Every frame of a source.
std::vector<SensorFrame> allFrames(FrameSource& source);

/// How often a warning whose text contains `part` was counted.
std::uint64_t warningCount(const IngestReport& report, const std::string& part);

std::string readBytes(const fs::path& file);
void writeFile(const fs::path& file, const std::string& bytes);

}  // namespace dynemo::test
