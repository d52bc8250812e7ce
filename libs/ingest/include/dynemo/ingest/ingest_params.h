// Which sensors of a rawlog are used, and how their observations are put together into frames.
#pragma once

#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/se3.h"

namespace dynemo {

struct LidarParams {
  /// Empty: the only sensor that gives scans.
  std::string label;
  double min_range_m = 0.5;
  double max_range_m = 100.0;
  /// Beam elevations of CObservationRotatingScan, row by row; that class does not store them.
  std::vector<double> elevations_deg;
  /// Sweeps per second of a spinning sensor whose observations carry no time per point; off when
  /// empty. A point with azimuth a was then taken (a − start) / 360° of a sweep after the stamp.
  std::optional<double> sweep_rate_hz;
  double sweep_start_rad = -std::numbers::pi;
  bool sweep_clockwise = false;
};

struct CameraParams {
  /// Empty: every camera; when there is none, the images that come with a depth camera.
  std::vector<std::string> labels;
};

struct OdometrySensorParams {
  /// Empty: the 3-D poses when there are any, else 2-D odometry, else the odometry actions.
  std::string label;
  /// Samples further apart than this are not interpolated between.
  double max_gap_s = 0.5;
  /// How far beyond a sample the motion may be continued at constant velocity.
  double max_extrapolation_s = 0.1;
};

struct ExternalDetectionParams {
  /// Labels of CObservation6DFeatures; empty: every one.
  std::vector<std::string> labels;
};

struct SyncParams {
  /// An image or detection joins a frame when it is at most this far from it.
  double max_image_offset_s = 0.05;
  /// Observations that arrive out of order by at most this are sorted.
  double sort_window_s = 0.5;
  /// Length of the beginning of a log from which the sensors are chosen.
  double probe_s = 2.0;
};

struct ClockParams {
  /// A longer jump forwards must be confirmed by the observations that follow.
  double max_forward_jump_s = 10.0;
  /// Consecutive observations that establish a clock that has jumped.
  int confirmations = 10;
};

struct IngestParams {
  LidarParams lidar;
  CameraParams cameras;
  OdometrySensorParams odometry;
  ExternalDetectionParams detections;
  SyncParams sync;
  ClockParams clock;
  /// T_base_sensor as x y z qx qy qz qw by sensor label, instead of what the log says.
  std::map<std::string, std::vector<double>> extrinsics;
  /// Largest memory that one object of a rawlog may ask for.
  double max_object_mb = 512.0;
};

void fields(FieldVisitor& v, LidarParams& p);
void fields(FieldVisitor& v, CameraParams& p);
void fields(FieldVisitor& v, OdometrySensorParams& p);
void fields(FieldVisitor& v, ExternalDetectionParams& p);
void fields(FieldVisitor& v, SyncParams& p);
void fields(FieldVisitor& v, ClockParams& p);
void fields(FieldVisitor& v, IngestParams& p);

/// T_base_sensor by sensor label from the extrinsics table. Throws ConfigError, naming every wrong
/// row.
std::map<std::string, Pose3> extrinsicsTable(const IngestParams& params);

}  // namespace dynemo
