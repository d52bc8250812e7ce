// The simulated sensors and the drift of the simulated odometry.
#pragma once

#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/se3.h"

namespace dynemo::simulation {

/// A spinning LiDAR. Each sweep turns counter-clockwise from azimuth −180°.
struct LidarSpec {
  int rings = 32;
  int columns = 1024;
  double rate_hz = 10.0;
  double elevation_min_rad = -0.3926990816987241;
  double elevation_max_rad = 0.3926990816987241;
  double min_range_m = 0.35;
  double max_range_m = 60.0;
  double sigma_m = 0.01;
  double dropout = 0.01;
  double grazing_rad = 0.1047197551196598;
  double quantum_m = 1.0 / 1024.0;
  bool motion_distortion = false;
  bool rotating_scan = false;
  /// T_base_lidar: x y z [m] yaw pitch roll [deg].
  std::vector<double> pose{-0.06, 0.01, 0.52, 3.0, 0.8, 0.5};

  double elevation_rad(int ring) const;
  /// Share of the sweep, from azimuth −180°, at which a column is shot: the middle of its sector.
  double turned(int column) const { return (column + 0.5) / columns; }
};

/// A global-shutter pinhole camera.
struct CameraSpec {
  int width = 848, height = 480;
  double fx = 608.0, fy = 607.0, cx = 424.6, cy = 238.3;
  /// Plumb bob: k1 k2 p1 p2 k3.
  std::vector<double> distortion{0.0, 0.0, 0.0, 0.0, 0.0};
  double rate_hz = 10.0;
  double delay_s = 0.0;
  double noise = 2.0;
  double blur_px = 0.45;
  double vignetting = 0.2;
  double exposure_drift = 0.08;
  int jpeg_quality = 88;
  /// T_base_camera before the turn into the optical frame: x y z [m] yaw pitch roll [deg].
  std::vector<double> pose{0.21, 0.035, 0.42, 1.5, -2.0, -0.4};
};

/// Odometry in 3-D: random walks with distance and turning, constant biases, white jitter.
struct PoseOdometrySpec {
  double rate_hz = 20.0;
  double xy_per_sqrt_m = 0.008;
  double xy_per_sqrt_rad = 0.004;
  double z_per_sqrt_m = 0.004;
  double tilt_per_sqrt_m_rad = 0.0005235987755982988;
  double yaw_per_sqrt_m_rad = 0.0026179938779914944;
  double yaw_per_sqrt_rad_rad = 0.004363323129985824;
  double scale_bias_sigma = 0.002;
  double yaw_bias_sigma_per_m_rad = 0.0003490658503988659;
  double z_bias_sigma_per_m = 0.001;
  double jitter_m = 0.003;
  double jitter_rad = 0.0006981317007977318;
};

/// Odometry of wheels; a hand-held sensor has none and reports its 3-D odometry flattened.
struct WheelOdometrySpec {
  double rate_hz = 20.0;
  double xy_per_sqrt_m = 0.02;
  double yaw_per_sqrt_m_rad = 0.006981317007977318;
  double yaw_per_sqrt_rad_rad = 0.013962634015954637;
  double scale_bias_sigma = 0.006;
  double yaw_bias_sigma_per_m_rad = 0.0006981317007977318;
};

struct SensorSpecs {
  /// Without it every noise, bias, drop-out and rounding is off.
  bool noise = true;
  LidarSpec lidar;
  CameraSpec camera;
  PoseOdometrySpec odom3d;
  WheelOdometrySpec odom2d;
};

void fields(FieldVisitor& v, LidarSpec& s);
void fields(FieldVisitor& v, CameraSpec& s);
void fields(FieldVisitor& v, PoseOdometrySpec& s);
void fields(FieldVisitor& v, WheelOdometrySpec& s);
void fields(FieldVisitor& v, SensorSpecs& s);

/// Throws ConfigError when a list has the wrong length; `origin` begins the message.
void check(const SensorSpecs& specs, const std::string& origin);

/// x y z [m] yaw pitch roll [deg].
Pose3 poseOf(const std::vector<double>& xyz_ypr_deg);
Pose3 T_base_lidar(const LidarSpec& spec);
/// Optical frame: x right, y down, z forward.
Pose3 T_base_camera(const CameraSpec& spec);

}  // namespace dynemo::simulation
