#include "dynemo/simulation/sensor_specs.h"

#include <cmath>
#include <numbers>

#include "dynemo/core/error.h"

namespace dynemo::simulation {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

void checkLength(const std::vector<double>& values, std::size_t length, const std::string& key) {
  if (values.size() != length)
    throw ConfigError(key + ": must have " + std::to_string(length) + " elements, has " +
                      std::to_string(values.size()));
}

}  // namespace

void fields(FieldVisitor& v, LidarSpec& s) {
  v.integer("rings", s.rings, "Rows of a sweep", Range::between(1, 512));
  v.integer("columns", s.columns, "Shots of each ring in a sweep", Range::between(8, 8192));
  v.number("rate_hz", s.rate_hz, "Sweeps per second", Range::between(0.1, 100));
  v.angle("elevation_min_deg", s.elevation_min_rad, "Lowest ring", Range::between(-89, 89));
  v.angle("elevation_max_deg", s.elevation_max_rad, "Highest ring", Range::between(-89, 89));
  v.number("min_range_m", s.min_range_m, "Nearer surfaces are not seen", Range::nonNegative());
  v.number("max_range_m", s.max_range_m, "Surfaces further away are not seen", Range::positive());
  v.number("sigma_m", s.sigma_m, "White noise of the range", Range::nonNegative());
  v.number("dropout", s.dropout, "Share of returns that are lost", Range::between(0, 1));
  v.angle("grazing_deg", s.grazing_rad, "Half of the returns at a flatter incidence are lost",
          Range::between(0, 90));
  v.number("quantum_m", s.quantum_m, "Coordinates are rounded to multiples; 0: not",
           Range::nonNegative());
  v.flag("motion_distortion", s.motion_distortion,
         "The sensor moves during the sweep; the stamp is its beginning");
  v.flag("rotating_scan", s.rotating_scan,
         "Write CObservationRotatingScan (range image) instead of CObservationPointCloud");
  v.numbers("pose", s.pose, "In the base frame: x y z [m] yaw pitch roll [deg]");
}

void fields(FieldVisitor& v, CameraSpec& s) {
  v.integer("width", s.width, "Columns", Range::between(16, 8192));
  v.integer("height", s.height, "Rows", Range::between(16, 8192));
  v.number("fx", s.fx, "Focal length in columns", Range::positive());
  v.number("fy", s.fy, "Focal length in rows", Range::positive());
  v.number("cx", s.cx, "Principal point; integers are pixel centres");
  v.number("cy", s.cy, "Principal point");
  v.numbers("distortion", s.distortion, "Plumb bob: k1 k2 p1 p2 k3");
  v.number("rate_hz", s.rate_hz, "Images per second", Range::between(0.1, 200));
  v.number("delay_s", s.delay_s, "Time after the multiples of the period", Range::between(0, 10));
  v.number("noise", s.noise, "White noise of the brightness, of 255", Range::between(0, 100));
  v.number("blur_px", s.blur_px, "Standard deviation of the point spread", Range::between(0, 5));
  v.number("vignetting", s.vignetting, "Loss of brightness in the corners", Range::between(0, 1));
  v.number("exposure_drift", s.exposure_drift, "Slow change of brightness", Range::between(0, 1));
  v.integer("jpeg_quality", s.jpeg_quality, "Of the image files", Range::between(1, 100));
  v.numbers("pose", s.pose, "In the base frame: x y z [m] yaw pitch roll [deg], looking along x");
}

void fields(FieldVisitor& v, PoseOdometrySpec& s) {
  v.number("rate_hz", s.rate_hz, "Poses per second", Range::between(0.1, 1000));
  v.number("xy_per_sqrt_m", s.xy_per_sqrt_m, "Random walk with distance", Range::nonNegative());
  v.number("xy_per_sqrt_rad", s.xy_per_sqrt_rad, "Random walk with turning", Range::nonNegative());
  v.number("z_per_sqrt_m", s.z_per_sqrt_m, "Random walk with distance", Range::nonNegative());
  v.angle("tilt_per_sqrt_m_deg", s.tilt_per_sqrt_m_rad, "Random walk of roll and pitch",
          Range::nonNegative());
  v.angle("yaw_per_sqrt_m_deg", s.yaw_per_sqrt_m_rad, "Random walk with distance",
          Range::nonNegative());
  v.angle("yaw_per_sqrt_rad_deg", s.yaw_per_sqrt_rad_rad, "Random walk with turning",
          Range::nonNegative());
  v.number("scale_bias_sigma", s.scale_bias_sigma, "Constant error of the scale, drawn once",
           Range::nonNegative());
  v.angle("yaw_bias_sigma_per_m_deg", s.yaw_bias_sigma_per_m_rad, "Constant drift, drawn once",
          Range::nonNegative());
  v.number("z_bias_sigma_per_m", s.z_bias_sigma_per_m, "Constant drift, drawn once",
           Range::nonNegative());
  v.number("jitter_m", s.jitter_m, "White noise of the position", Range::nonNegative());
  v.angle("jitter_deg", s.jitter_rad, "White noise of the rotation", Range::nonNegative());
}

void fields(FieldVisitor& v, WheelOdometrySpec& s) {
  v.number("rate_hz", s.rate_hz, "Poses per second", Range::between(0.1, 1000));
  v.number("xy_per_sqrt_m", s.xy_per_sqrt_m, "Random walk with distance", Range::nonNegative());
  v.angle("yaw_per_sqrt_m_deg", s.yaw_per_sqrt_m_rad, "Random walk with distance",
          Range::nonNegative());
  v.angle("yaw_per_sqrt_rad_deg", s.yaw_per_sqrt_rad_rad, "Random walk with turning",
          Range::nonNegative());
  v.number("scale_bias_sigma", s.scale_bias_sigma, "Constant error of the scale, drawn once",
           Range::nonNegative());
  v.angle("yaw_bias_sigma_per_m_deg", s.yaw_bias_sigma_per_m_rad, "Constant drift, drawn once",
          Range::nonNegative());
}

void fields(FieldVisitor& v, SensorSpecs& s) {
  v.flag("noise", s.noise, "All noise, bias, drop-outs and rounding");
  v.section("lidar", s.lidar, "A spinning 3-D LiDAR");
  v.section("camera", s.camera, "A pinhole camera");
  v.section("odom3d", s.odom3d, "Odometry in 3-D");
  v.section("odom2d", s.odom2d, "Odometry of the wheels");
}

void check(const SensorSpecs& specs, const std::string& origin) {
  checkLength(specs.lidar.pose, 6, origin + ": lidar.pose");
  checkLength(specs.camera.pose, 6, origin + ": camera.pose");
  checkLength(specs.camera.distortion, 5, origin + ": camera.distortion");
  if (specs.lidar.elevation_max_rad < specs.lidar.elevation_min_rad)
    throw ConfigError(origin + ": lidar.elevation_max_deg: must be ≥ elevation_min_deg");
}

double LidarSpec::elevation_rad(int ring) const {
  if (rings == 1) return 0.5 * (elevation_min_rad + elevation_max_rad);
  const double step_rad = (elevation_max_rad - elevation_min_rad) / (rings - 1);
  return elevation_max_rad - step_rad * ring;
}

Pose3 poseOf(const std::vector<double>& p) {
  return Pose3::fromYawPitchRoll(p[0], p[1], p[2], p[3] * kDegree, p[4] * kDegree, p[5] * kDegree);
}

Pose3 T_base_lidar(const LidarSpec& spec) { return poseOf(spec.pose); }

Pose3 T_base_camera(const CameraSpec& spec) {
  Matrix3 R_body_optical;
  R_body_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return poseOf(spec.pose) * Pose3(R_body_optical, Vector3::Zero());
}

}  // namespace dynemo::simulation
