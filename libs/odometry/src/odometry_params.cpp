#include "dynemo/odometry/odometry_params.h"

namespace dynemo {

LocalMapParams::LocalMapParams() { surface.scan_lines = true; }

KeyframeGicpParams::KeyframeGicpParams() {
  surface.leaf_m = 0.1;
  surface.max_flatness = 1.0;
  // One distance, no kernel, no gate.
  registration.min_correspondence_m = correspondence_m;
  registration.kernel_m = 1e3;
  registration.min_normal_cosine = -1.0;
  registration.min_observed_share = 0.0;
}

void fields(FieldVisitor& v, PredictionParams& p) {
  v.choice("source", p.source, {"constant_velocity", "rawlog_odometry"},
           "What predicts the next pose; rawlog_odometry falls back to constant velocity where the "
           "log has none");
  v.number("sigma_acceleration_m_s2", p.sigma_acceleration_m_s2,
           "Standard deviation of the acceleration that constant velocity neglects",
           Range::positive());
  v.number("sigma_angular_acceleration_rad_s2", p.sigma_angular_acceleration_rad_s2,
           "Standard deviation of the angular acceleration that constant velocity neglects",
           Range::positive());
  v.number("calm_share", p.calm_share,
           "Lower limit of the freedom of motion within a sweep, as a share of these "
           "accelerations: a robot that "
           "moves calmly is given less",
           {0.0, 1.0, true});
  v.number(
      "sigma_vertical_m_s", p.sigma_vertical_m_s,
      "Standard deviation of the vertical speed, which counts where scans do not show the height",
      Range::positive());
  v.number("odometry_sigma_translation_m", p.odometry_sigma_translation_m,
           "Standard deviation of the log's odometry from one scan to the next", Range::positive());
  v.number("odometry_sigma_rotation_rad", p.odometry_sigma_rotation_rad,
           "Standard deviation of the log's odometry from one scan to the next", Range::positive());
  v.number("max_gap_s", p.max_gap_s,
           "After a longer time without a scan the velocity counts as unknown", Range::positive());
}

void fields(FieldVisitor& v, LocalMapParams& p) {
  v.flag("deskew", p.deskew, "Use the times of the points, where scans have them");
  v.section("prediction", p.prediction, "Prediction of the next pose");
  v.section("surface", p.surface, "Reduction of scans to points with normals");
  v.section("map", p.map, "The local map");
  v.section("registration", p.registration, "Registration of a scan to the map");
  v.number("initial_sigma_m", p.initial_sigma_m,
           "First guess of how far predictions displace points", Range::positive());
  v.number("sigma_memory", p.sigma_memory,
           "Share of the past in the running mean square of the predictions' errors", {0.0, 0.999});
  v.number("max_correspondence_m", p.max_correspondence_m,
           "Upper limit of the first correspondence distance, which is three times that error",
           Range::positive());
  v.number("min_inlier_ratio", p.min_inlier_ratio,
           "With a smaller share of close correspondences a registration is tried again wider, and "
           "in the end refused",
           Range::between(0.0, 1.0));
  v.integer("max_lost_scans", p.max_lost_scans, "After as many refused scans the map is begun anew",
            Range::between(1, 1e6));
  v.optionalNumber("map_radius_m", p.map_radius_m,
                   "Farther parts of the map are forgotten; null keeps all", Range::positive());
  v.integer("min_points", p.min_points, "Scans with fewer points after reduction are refused",
            Range::between(6, 1e6));
}

void fields(FieldVisitor& v, KeyframeGicpParams& p) {
  v.section("surface", p.surface, "Reduction of scans to points with normals");
  v.section("registration", p.registration, "Registration of a scan to the keyframe");
  v.number("correspondence_m", p.correspondence_m,
           "Largest distance of correspondences at the start", Range::positive());
  v.number("keyframe_translation_m", p.keyframe_translation_m, "Distance that makes a keyframe",
           Range::positive());
  v.number("keyframe_rotation_rad", p.keyframe_rotation_rad, "Rotation that makes a keyframe",
           Range::positive());
  v.integer("min_points", p.min_points, "Scans with fewer points after reduction are refused",
            Range::between(6, 1e6));
}

void fields(FieldVisitor& v, OdometryParams& p) {
  v.text("method", p.method, "local_map or keyframe_gicp");
  v.integer("threads", p.threads, "Threads of the registration; the result does not depend on it",
            Range::between(1, 64));
  v.section("local_map", p.local_map, "Scan to local map");
  v.section("keyframe_gicp", p.keyframe_gicp, "Scan to keyframe, as the baseline");
}

}  // namespace dynemo
