// Parameters of LiDAR odometry.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "dynemo/core/fields.h"
#include "dynemo/odometry/registration.h"
#include "dynemo/odometry/surface_points.h"
#include "dynemo/odometry/voxel_hash_map.h"

namespace dynemo {

enum class Prediction : std::uint8_t { kConstantVelocity, kRawlogOdometry };

/// What is believed about the next pose before its scan is seen.
struct PredictionParams {
  Prediction source = Prediction::kRawlogOdometry;
  double sigma_acceleration_m_s2 = 5.0;
  double sigma_angular_acceleration_rad_s2 = 10.0;
  double calm_share = 0.05;
  double sigma_vertical_m_s = 0.5;
  double odometry_sigma_translation_m = 0.02;
  double odometry_sigma_rotation_rad = 0.01;
  double max_gap_s = 1.0;
};
void fields(FieldVisitor& v, PredictionParams& p);

struct LocalMapParams {
  bool deskew = true;
  PredictionParams prediction;
  SurfaceParams surface;
  VoxelHashMapParams map;
  RegistrationParams registration;
  double initial_sigma_m = 0.3;
  double sigma_memory = 0.9;
  double max_correspondence_m = 1.0;
  double min_inlier_ratio = 0.3;
  int max_lost_scans = 5;
  std::optional<double> map_radius_m = 150.0;
  int min_points = 50;

  LocalMapParams();
};
void fields(FieldVisitor& v, LocalMapParams& p);

struct KeyframeGicpParams {
  SurfaceParams surface;
  RegistrationParams registration;
  double correspondence_m = 1.0;
  double keyframe_translation_m = 1.0;
  double keyframe_rotation_rad = 1.0;
  int min_points = 50;

  KeyframeGicpParams();
};
void fields(FieldVisitor& v, KeyframeGicpParams& p);

struct OdometryParams {
  std::string method = "local_map";
  int threads = 2;
  LocalMapParams local_map;
  KeyframeGicpParams keyframe_gicp;
};
void fields(FieldVisitor& v, OdometryParams& p);

}  // namespace dynemo
