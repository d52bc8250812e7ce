#include "dynemo/ingest/ingest_params.h"

#include <cmath>

#include "dynemo/core/error.h"

namespace dynemo {

void fields(FieldVisitor& v, LidarParams& p) {
  v.text("label", p.label, "Sensor label of the scans; empty: the only one there is");
  v.number("min_range_m", p.min_range_m, "Nearer points are removed", Range::nonNegative());
  v.number("max_range_m", p.max_range_m, "Points further away are removed", Range::positive());
  v.numbers("elevations_deg", p.elevations_deg,
            "Elevation of each row of CObservationRotatingScan, which does not store them");
  v.optionalNumber(
      "sweep_rate_hz", p.sweep_rate_hz,
      "Sweeps per second, to time the points of scans that carry no time per point; null: none",
      Range::positive());
  v.angle("sweep_start_deg", p.sweep_start_rad, "Azimuth at which a sweep begins",
          Range::between(-360, 360));
  v.flag("sweep_clockwise", p.sweep_clockwise, "The sensor turns clockwise seen from above");
}

void fields(FieldVisitor& v, CameraParams& p) {
  v.texts("labels", p.labels, "Sensor labels of the images; empty: all");
}

void fields(FieldVisitor& v, OdometrySensorParams& p) {
  v.text(
      "label", p.label,
      "Sensor label of the odometry; empty: 3-D poses, else 2-D odometry, else odometry actions");
  v.number("max_gap_s", p.max_gap_s, "Samples further apart are not interpolated between",
           Range::nonNegative());
  v.number("max_extrapolation_s", p.max_extrapolation_s,
           "How far beyond a sample the motion is continued", Range::nonNegative());
}

void fields(FieldVisitor& v, ExternalDetectionParams& p) {
  v.texts("labels", p.labels, "Sensor labels of CObservation6DFeatures with entities; empty: all");
}

void fields(FieldVisitor& v, SyncParams& p) {
  v.number("max_image_offset_s", p.max_image_offset_s,
           "An image or detection joins the nearest frame within this time", Range::nonNegative());
  v.number("sort_window_s", p.sort_window_s,
           "Observations out of order by at most this time are sorted", Range::nonNegative());
  v.number("probe_s", p.probe_s, "Beginning of a log from which the sensors are chosen",
           Range::between(0, 60));
}

void fields(FieldVisitor& v, ClockParams& p) {
  v.number("max_forward_jump_s", p.max_forward_jump_s,
           "A longer jump of the stamps must be confirmed by those that follow", Range::positive());
  v.integer("confirmations", p.confirmations,
            "Consecutive observations that establish a clock that has jumped",
            Range::between(1, 1000));
}

void fields(FieldVisitor& v, IngestParams& p) {
  v.section("lidar", p.lidar, "Scans");
  v.section("cameras", p.cameras, "Images");
  v.section("odometry", p.odometry, "Odometry stored in the log");
  v.section("detections", p.detections, "Entity detections stored in the log");
  v.section("sync", p.sync, "How observations form frames");
  v.section("clock", p.clock, "What happens when stamps jump");
  v.table("extrinsics", p.extrinsics,
          "Sensor label: [x, y, z, qx, qy, qz, qw] of the sensor in the base frame, instead of the "
          "log's");
  v.number("max_object_mb", p.max_object_mb, "Memory one object of a rawlog may ask for",
           Range::between(16, 65536));
}

std::map<std::string, Pose3> extrinsicsTable(const IngestParams& params) {
  std::map<std::string, Pose3> table;
  std::string violations;
  for (const auto& [label, row] : params.extrinsics) {
    bool finite = row.size() == 7;
    for (const double value : row) finite = finite && std::isfinite(value);
    const Eigen::Quaterniond q = finite ? Eigen::Quaterniond(row[6], row[3], row[4], row[5])
                                        : Eigen::Quaterniond(0, 0, 0, 0);
    if (std::abs(q.norm() - 1.0) > 1e-2)
      violations += "\n  extrinsics." + label +
                    ": must be 7 numbers x y z qx qy qz qw with a unit quaternion";
    else
      table[label] = Pose3(q, Vector3(row[0], row[1], row[2]));
  }
  if (!violations.empty()) throw ConfigError("wrong sensor poses:" + violations);
  return table;
}

}  // namespace dynemo
