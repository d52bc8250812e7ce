#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sensor_statistics.h"

namespace dynemo {
namespace {

std::string fixed(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string shortest(double value) {
  char text[48];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

std::string quoted(const SensorInspection& s) {
  return (s.label.empty() ? std::string("(no label)") : "'" + s.label + "'") + " (" + s.class_name +
         ")";
}

/// Collects the findings about one log.
class Judge {
 public:
  Judge(const InspectionParams& params, Inspection& inspection)
      : params_(params), log_(inspection) {}

  void all() {
    file();
    for (const SensorInspection& s : log_.sensors) {
      if (s.use == UseOfSensor::kNotUsed) continue;
      stamps(s);
      mounting(s);
      if (s.camera) camera(*s.camera, s);
      if (s.scan) scan(*s.scan, s);
    }
    roles();
    tags();
    ingest();
  }

 private:
  void add(Severity severity, std::string what, std::string fix) {
    log_.findings.push_back({severity, std::move(what), std::move(fix)});
  }
  void file();
  void stamps(const SensorInspection& s);
  void mounting(const SensorInspection& s);
  void camera(const CameraInspection& c, const SensorInspection& s);
  void scan(const ScanInspection& scan, const SensorInspection& s);
  void roles();
  void tags();
  void ingest();
  std::ptrdiff_t sensorsOf(UseOfSensor use) const {
    return std::count_if(log_.sensors.begin(), log_.sensors.end(),
                         [use](const SensorInspection& s) { return s.use == use; });
  }
  bool has(UseOfSensor use) const { return sensorsOf(use) > 0; }
  /// Depth cameras come with images too.
  bool hasImages() const {
    return std::any_of(log_.sensors.begin(), log_.sensors.end(),
                       [](const SensorInspection& s) { return s.camera.has_value(); });
  }
  std::string name() const { return log_.rawlog.filename().string(); }

  const InspectionParams& params_;
  Inspection& log_;
};

void Judge::file() {
  if (!log_.damage.empty())
    add(Severity::kWarning, "the file is damaged, the rest is not used: " + log_.damage,
        "record or copy it again; dynemo-prep trim " + name() +
            " -o REPAIRED.rawlog saves what can be read");
  if (log_.null_objects > 0)
    add(Severity::kWarning,
        std::to_string(log_.null_objects) +
            " stored null objects, at which other MRPT programs crash",
        "dynemo-prep trim " + name() + " -o REPAIRED.rawlog leaves them out");
}

void Judge::stamps(const SensorInspection& s) {
  if (s.without_stamp > 0)
    add(Severity::kWarning,
        quoted(s) + ": " + std::to_string(s.without_stamp) + " of " + std::to_string(s.count) +
            " observations have no valid time stamp and are not used",
        "stamp the observations when recording");
  if (s.jumps_back > 0)
    add(Severity::kWarning,
        quoted(s) + ": stamps jump back " + std::to_string(s.jumps_back) + " times",
        "record with a clock that is not set while recording; dynemo-prep trim cuts the log there");
  if (s.gaps > 0 && s.longest_gap_at)
    add(Severity::kWarning,
        quoted(s) + ": " + std::to_string(s.gaps) + " gaps, the longest of " +
            fixed(s.longest_gap_s, 2) + " s at " + s.longest_gap_at->text() + " (" +
            fixed(secondsBetween(*log_.first, *s.longest_gap_at), 2) + " s after the start)",
        s.use == UseOfSensor::kOdometry
            ? "over gaps of more than sensors.odometry.max_gap_s the motion is not known; raise it "
              "when the robot stood still or moved evenly"
            : "check the recording; dynemo-prep trim keeps the part without gaps");
  if (s.other_clock)
    add(s.use == UseOfSensor::kOdometry ? Severity::kWarning : Severity::kError,
        quoted(s) + ": its stamps differ by " + fixed(s.clock_offset_s, 3) +
            " s from those of the other sensors: it has a clock of its own",
        "rawlog-edit --keep-label and --remap-timestamps \"1;" + fixed(-s.clock_offset_s, 3) +
            "\", then dynemo-prep merge; better: synchronise the clocks and record again" +
            (s.use == UseOfSensor::kOdometry ? "; or do without: --set odometry.source=lidar"
                                             : ""));
}

void Judge::mounting(const SensorInspection& s) {
  if (s.use == UseOfSensor::kOdometry || params_.sensors.extrinsics.contains(s.label)) return;
  const std::string fix = "dynemo-prep set-extrinsics --sensor " + s.label +
                          "=X,Y,Z,YAW,PITCH,ROLL " + name() +
                          " -o FIXED.rawlog, or the key sensors.extrinsics";
  if (!s.T_base_sensor) {
    add(Severity::kError, quoted(s) + ": its pose on the robot is not a pose", fix);
    return;
  }
  const bool at_origin = local(Pose3(), *s.T_base_sensor).norm() < 1e-9;
  if (at_origin && s.use == UseOfSensor::kImage)
    add(Severity::kWarning,
        quoted(s) +
            ": sits in the robot's origin and looks straight up, so its pose was hardly set",
        fix);
  else if (at_origin && s.use == UseOfSensor::kScan && hasImages())
    add(Severity::kHint, quoted(s) + ": sits in the robot's origin; is that so?", fix);
  if (s.pose_changes > 0)
    add(Severity::kHint,
        quoted(s) + ": its pose on the robot differs from the first one " +
            std::to_string(s.pose_changes) + " times",
        "fine for a sensor that is moved by the robot; else " + fix);
}

void Judge::camera(const CameraInspection& c, const SensorInspection& s) {
  const std::string fix = "dynemo-prep set-calibration --label " + s.label +
                          " --file CALIBRATION.yaml " + name() + " -o FIXED.rawlog";
  if (!(c.fx > 0 && c.fy > 0) || c.width == 0)
    add(Severity::kWarning, quoted(s) + ": no calibration, so no tag can be measured", fix);
  if (c.external_missing > 0)
    add(Severity::kWarning,
        quoted(s) + ": " + std::to_string(c.external_missing) + " of " +
            std::to_string(c.external) + " image files are missing",
        "put them into the folder " + log_.rawlog.stem().string() + "_Images beside the rawlog");
}

void Judge::scan(const ScanInspection& scan, const SensorInspection& s) {
  const bool spinning = s.class_name == "CObservationPointCloud";
  if (!scan.point_times && spinning && !params_.sensors.lidar.sweep_rate_hz)
    add(Severity::kHint,
        quoted(s) + ": no time per point, so the motion during a sweep is not taken out",
        "when it is a spinning LiDAR, add --set sensors.lidar.sweep_rate_hz=" +
            shortest(s.rate_hz()) + " (and sweep_start_deg, sweep_clockwise)");
  if (s.class_name == "CObservationRotatingScan" && params_.sensors.lidar.elevations_deg.empty())
    add(Severity::kWarning, quoted(s) + ": this class does not store the elevation of its beams",
        "--set \"sensors.lidar.elevations_deg=[…]\" with one angle for each row");
  if (s.count > 0 && scan.sum_points == 0 && scan.max_points == 0)
    add(Severity::kWarning, quoted(s) + ": no points in the rawlog itself",
        "external clouds must lie in the image folder");
}

void Judge::roles() {
  if (!log_.runnable()) return;
  const bool detections = has(UseOfSensor::kDetections);
  if (!hasImages() && !detections)
    add(Severity::kWarning, "neither images nor entity detections: the map will hold no entities",
        "record a camera, or give detections of another program with --detections FILE.csv");
  if (!has(UseOfSensor::kScan))
    add(Severity::kHint, "no LiDAR: no clouds, no fragments of entities, no floor", "");
  if (!has(UseOfSensor::kOdometry) && !log_.other_objects.contains("CActionCollection"))
    add(Severity::kHint,
        has(UseOfSensor::kScan) ? "no odometry: dynemo-slam estimates it from the scans"
                                : "no odometry: the robot is located by the entities in view only",
        "");
  if (hasImages() && detections)
    add(Severity::kHint,
        "the log holds entity detections beside the images, so entities that both show are "
        "detected twice",
        "--set perception.detectors=[external] takes the stored ones only");
}

void Judge::tags() {
  if (log_.images_searched == 0) return;
  if (log_.tags.empty())
    add(Severity::kWarning,
        "no tag of family " + params_.tags.family + " in " + std::to_string(log_.images_searched) +
            " images",
        "try another --family; tags need an edge of ten pixels and a white border");
  double largest_px = 0.0;
  for (const SurveyedTag& tag : log_.tags) largest_px = std::max(largest_px, tag.max_edge_px);
  if (!log_.tags.empty() && largest_px < 15.0)
    add(Severity::kWarning,
        "the largest tag has an edge of " + fixed(largest_px, 0) + " pixels only",
        "use larger tags or go nearer: poses get usable above some 20 pixels");
}

/// Warnings of reading that no finding explains yet.
void Judge::ingest() {
  for (const auto& [what, count] : log_.ingest_warnings) {
    const bool explained = what.starts_with("rawlog damaged") ||
                           what.find("without valid time stamp") != std::string::npos ||
                           what.find("without camera calibration") != std::string::npos ||
                           what.find("null object") != std::string::npos ||
                           what.find("image file not found") != std::string::npos;
    if (explained) continue;
    std::string fix;
    if (what.find("of the configured sensor") != std::string::npos)
      fix =
          "name a sensor of the table above, or none: it is found by itself when it is the only "
          "one of its kind";
    else if (what.find("size is not that of its calibration") != std::string::npos)
      fix = "dynemo-prep set-calibration with a calibration of that size";
    else if (what.find("without scan within") != std::string::npos || what.find("without") == 0)
      fix = "sensors.sync.max_image_offset_s says how far an image may be from its scan";
    add(Severity::kWarning, "reading: " + what + ": " + std::to_string(count), fix);
  }
}

}  // namespace

void judge(const InspectionParams& params, Inspection& inspection) {
  Judge(params, inspection).all();
}

}  // namespace dynemo
