// ROS 1 bags as rawlogs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace dynemo {

struct RosbagImportParams {
  /// Sensor label by topic: only these topics; empty: every topic of a known type, labelled by its
  /// name with '_' for '/'.
  std::map<std::string, std::string> labels;
  /// Frame of the robot; empty: base_link, else base_footprint, else what the bag's odometry calls
  /// the robot.
  std::string base_frame;
  bool compressed = true;
};

struct RosbagImportReport {
  /// Observations written by "label (class)".
  std::map<std::string, std::uint64_t> written;
  /// Messages left out, by "topic (type)".
  std::map<std::string, std::uint64_t> left_out;
  std::map<std::string, std::uint64_t> warnings;
  std::string base_frame;
};

/// Reads sensor_msgs/PointCloud2 (→ CObservationPointCloud with intensities when there are any),
/// sensor_msgs/Image and CompressedImage (→ CObservationImage in NAME_Images, JPEG and PNG as they
/// come, raw ones as PNG), sensor_msgs/CameraInfo (→ their calibration), nav_msgs/Odometry (→
/// CObservationRobotPose of the base frame) and tf (→ where the sensors sit). Stamps are those of
/// the headers, or the time of reception when a header has none. Points that are not finite are
/// left out. The rawlog appears when it is complete. Throws DataError when the bag cannot be read
/// or gives nothing, or when the output exists; damage after a usable beginning is a counted
/// warning.
RosbagImportReport importRosbag(const std::filesystem::path& bag,
                                const std::filesystem::path& rawlog,
                                const RosbagImportParams& params);

}  // namespace dynemo
