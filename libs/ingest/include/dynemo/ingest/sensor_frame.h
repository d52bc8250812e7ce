// What the front-end receives per frame: one scan, the images and detections that belong to it, and
// the odometry interpolated to each stamp.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/ids.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

enum class DistortionModel : std::uint8_t { kNone, kPlumbBob, kKannalaBrandt };

/// Pinhole intrinsics in pixels; integer pixel coordinates are pixel centres (OpenCV's convention).
struct CameraModel {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  DistortionModel distortion = DistortionModel::kNone;
  /// Plumb bob: k1 k2 p1 p2 k3 (k4 k5 k6); Kannala–Brandt: k1 k2 k3 k4.
  std::array<double, 8> coefficients{};

  bool valid() const { return width > 0 && height > 0 && fx > 0 && fy > 0; }
};

/// Odometry at one instant. The covariance, when the source gives one, is the one accumulated since
/// the start of the odometry, of the right tangent of T_odom_base.
struct OdometryState {
  Pose3 T_odom_base;
  std::optional<Matrix6> accumulated_covariance;
};

struct CameraImage {
  Stamp stamp;
  std::string label;
  cv::Mat grey;  ///< CV_8UC1
  CameraModel model;
  Pose3 T_base_camera;  ///< optical frame: x right, y down, z forward
  /// Odometry at the image's stamp; empty when the log has none there.
  std::optional<OdometryState> odometry;
};

/// An entity pose measured by another program.
struct ExternalDetection {
  Stamp stamp;
  EntityId entity{};
  std::string class_name;  ///< "agent", "object", or empty when the source does not say
  Pose3 T_base_entity;     ///< base frame at the detection's own stamp
  /// Of the right tangent of T_base_entity; empty when the source gives none.
  std::optional<Matrix6> covariance;
  std::string sensor_label;
  std::optional<OdometryState> odometry;
};

/// One synchronised frame. The stamp is the scan's, or the first image's or detection's when there
/// is no scan.
struct SensorFrame {
  std::uint64_t index = 0;
  Stamp stamp;
  std::optional<Scan> scan;
  std::vector<CameraImage> images;
  std::vector<ExternalDetection> detections;
  std::optional<OdometryState> odometry;
};

}  // namespace dynemo
