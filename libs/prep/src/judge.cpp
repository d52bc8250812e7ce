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

/// A word for the shell, in quotes only where it needs them.
std::string word(const std::string& text) {
  const bool plain = !text.empty() && text.find_first_not_of(
                                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                          "0123456789_-./=,:+@%") == std::string::npos;
  if (plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string share(std::uint64_t count, std::uint64_t all) {
  return std::to_string(count) + " of " + std::to_string(all);
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
    odometry();
    tags();
    ingest();
  }

 private:
  void add(Severity severity, std::string what, std::string fix, std::string commands = {}) {
    log_.findings.push_back({severity, std::move(what), std::move(fix), std::move(commands)});
  }
  void file();
  void stamps(const SensorInspection& s);
  void mounting(const SensorInspection& s);
  void camera(const CameraInspection& c, const SensorInspection& s);
  void scan(const ScanInspection& scan, const SensorInspection& s);
  void otherClock(const SensorInspection& s);
  std::string linkImages(const char* part) const;
  std::string leaveOut(const SensorInspection& s) const;
  std::string putRight(const SensorInspection& s) const;
  bool scansFollow() const;
  void missingFiles(const CameraInspection& c, const SensorInspection& s);
  void roles();
  void odometry();
  void lidarOdometry(const std::string& why, bool recorded);
  void tags();
  void ingest();
  std::ptrdiff_t sensorsOf(UseOfSensor use) const {
    return std::count_if(log_.sensors.begin(), log_.sensors.end(),
                         [use](const SensorInspection& s) { return s.use == use; });
  }
  bool has(UseOfSensor use) const { return sensorsOf(use) > 0; }
  /// Depth cameras come with images too.
  std::ptrdiff_t sensorsWithImages() const {
    return std::count_if(log_.sensors.begin(), log_.sensors.end(),
                         [](const SensorInspection& s) { return s.camera.has_value(); });
  }
  bool hasImages() const { return sensorsWithImages() > 0; }
  /// For commands: the log, and files beside it.
  std::string log() const { return word(log_.rawlog.string()); }
  std::string beside(const std::string& ending) const {
    return word((log_.rawlog.parent_path() / (log_.rawlog.stem().string() + ending)).string());
  }

  const InspectionParams& params_;
  Inspection& log_;
};

void Judge::file() {
  // What is no rawlog at all is one error, which is there already.
  if (!log_.damage.empty() && log_.objects > 0)
    add(Severity::kWarning, "the file is damaged, the rest is not used: " + log_.damage,
        "record or copy it again; what can be read is saved by",
        "dynemo-prep trim " + log() + " -o " + beside("_repaired.rawlog"));
  if (log_.null_objects > 0)
    add(Severity::kWarning,
        std::to_string(log_.null_objects) +
            " stored null objects, at which other MRPT programs crash",
        "they are left out by", "dynemo-prep trim " + log() + " -o " + beside("_repaired.rawlog"));
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
            fixed(secondsBetween(s.other_clock ? *s.first : *log_.first, *s.longest_gap_at), 2) +
            " s after the start)",
        s.use == UseOfSensor::kOdometry
            ? "over gaps of more than sensors.odometry.max_gap_s the motion is not known; raise it "
              "when the robot stood still or moved evenly"
            : "check the recording; dynemo-prep trim keeps the part without gaps");
  if (s.other_clock) otherClock(s);
}

/// dynemo-slam takes no odometry of another clock; images and detections it needs.
void Judge::otherClock(const SensorInspection& s) {
  // A robot that turns by 1 rad/s puts what is 5 m away 5 cm beside its place by then.
  constexpr double kTied_s = 0.0101;
  const bool odometry = s.use == UseOfSensor::kOdometry;
  const bool tied = s.clock_tie && s.clock_tie->uncertainty_s <= kTied_s;
  const bool can_be_named = !s.label.empty() && !log_.actions_and_frames;
  std::string what = quoted(s) + ": its stamps differ by " + fixed(s.clock_offset_s, 3) + " s" +
                     (tied ? " (+- " + fixed(s.clock_tie->uncertainty_s, 3) + " s)" : "") +
                     " from those of the other sensors: it has a clock of its own" +
                     (odometry ? ", so that dynemo-slam cannot use it" : "");
  std::string fix = "synchronise the clocks and record again", commands;
  if (!tied)
    what += s.clock_tie ? ", and the order of the log tells the difference only to " +
                              fixed(s.clock_tie->uncertainty_s, 3) + " s"
                        : ", and nothing in the log ties the clocks: it was recorded at another "
                          "time, or the log was sorted by stamps";
  if (odometry && scansFollow()) {
    fix += "; nothing else needs to be done, since the scans alone tell the motion";
  } else if (!tied) {
    fix = "there is no remedy in this log: " + fix + "; what can be used of it is the rest" +
          (can_be_named ? ", which is left by" : "");
    if (can_be_named) commands = leaveOut(s);
  } else if (can_be_named) {
    fix += "; its stamps are put right, to that and to what its recording was delayed by, by";
    commands = putRight(s);
  }
  add(odometry ? Severity::kWarning : Severity::kError, std::move(what), std::move(fix),
      std::move(commands));
}

/// Parts of the log refer to the images of the whole.
std::string Judge::linkImages(const char* part) const {
  const bool in_files = std::any_of(
      log_.sensors.begin(), log_.sensors.end(),
      [](const SensorInspection& any) { return any.camera && any.camera->external > 0; });
  if (!in_files) return {};
  return "ln -s " + word(log_.rawlog.stem().string() + "_Images") + " " + beside(part) + "\n";
}

std::string Judge::leaveOut(const SensorInspection& s) const {
  const std::string remove = "rawlog-edit -q -i " + log() + " -o " + beside("_rest.rawlog") +
                             " --remove-label " + word(s.label) + "\n";
  std::string commands = remove + linkImages("_rest_Images");
  commands.pop_back();
  return commands;
}

std::string Judge::putRight(const SensorInspection& s) const {
  const std::string own = beside("_own.rawlog"), shifted = beside("_shifted.rawlog");
  return "rawlog-edit -q -i " + log() + " -o " + own + " --keep-label " + word(s.label) +
         "\nrawlog-edit -q -i " + own + " -o " + shifted + " --remap-timestamps '1;" +
         fixed(-s.clock_offset_s, 3) + "'\n" + leaveOut(s) + "\n" + linkImages("_shifted_Images") +
         "dynemo-prep merge " + beside("_rest.rawlog") + " " + shifted + " -o " +
         beside("_one_clock.rawlog");
}

/// Whether LiDAR odometry was tried, and does.
bool Judge::scansFollow() const {
  return log_.odometry_trial &&
         10 * log_.odometry_trial->followed >= 9 * log_.odometry_trial->scans;
}

void Judge::mounting(const SensorInspection& s) {
  if (s.use == UseOfSensor::kOdometry || params_.sensors.extrinsics.contains(s.label)) return;
  const std::string fix = "dynemo-prep set-extrinsics --sensor " + word(s.label) +
                          "=X,Y,Z,YAW,PITCH,ROLL " + log() + " -o " + beside("_mounted.rawlog") +
                          ", or the key sensors.extrinsics";
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
  const std::string fix = "dynemo-prep set-calibration --label " + word(s.label) +
                          " --file CALIBRATION.yaml " + log() + " -o " +
                          beside("_calibrated.rawlog");
  if (!(c.fx > 0 && c.fy > 0) || c.width == 0)
    add(Severity::kWarning, quoted(s) + ": no calibration, so no tag can be measured", fix);
  if (c.external_missing > 0) missingFiles(c, s);
}

void Judge::missingFiles(const CameraInspection& c, const SensorInspection& s) {
  const bool all = c.embedded == 0 && c.external_missing >= c.external;
  const bool nothing_else = sensorsWithImages() == 1 && !has(UseOfSensor::kDetections);
  add(all && nothing_else ? Severity::kError : Severity::kWarning,
      quoted(s) + ": " + share(c.external_missing, c.external) + " image files are missing" +
          (all && nothing_else ? ": no entity can be found" : ""),
      "put them into the folder " + beside("_Images"));
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
  if (detections)
    add(Severity::kHint,
        "the log holds entity detections, by id alone: what the entities are stands in the entity "
        "file, which dynemo-slam still needs",
        "dynemo-slam --entities ENTITIES.yaml …");
  if (hasImages() && detections)
    add(Severity::kHint,
        "the log holds entity detections beside the images, so entities that both show are "
        "detected twice",
        "--set perception.detectors=[external] takes the stored ones only");
}

/// Where dynemo-slam would have the motion from.
void Judge::odometry() {
  if (log_.frames == 0) return;
  const bool recorded =
      has(UseOfSensor::kOdometry) || log_.other_objects.contains("CActionCollection");
  const std::uint64_t without = log_.frames - log_.frames_with_odometry;
  if (log_.odometry_trial || (log_.frames_with_odometry == 0 && !recorded))
    return lidarOdometry(!recorded                        ? "no odometry"
                         : log_.frames_with_odometry == 0 ? "the log's odometry cannot be used"
                                                          : "odometry.source is lidar",
                         recorded);
  if (log_.frames_with_odometry == 0)
    return add(Severity::kError,
               "the log's odometry cannot be used, no frame has any at its stamp: the robot's "
               "motion would not be known",
               has(UseOfSensor::kScan) ? "add --set odometry.source=lidar, here and for dynemo-slam"
                                       : "record odometry, or scans");
  // A few at the beginning and the end are usual.
  if (10 * without > log_.frames)
    add(Severity::kWarning,
        share(without, log_.frames) +
            " frames have no odometry at their stamp: there the robot is taken to stand still",
        has(UseOfSensor::kScan)
            ? "--set odometry.source=lidar takes the motion from the scans (try it with check); "
              "sensors.odometry.max_gap_s bridges short gaps"
            : "sensors.odometry.max_gap_s bridges short gaps");
}

void Judge::lidarOdometry(const std::string& why, bool recorded) {
  if (!log_.odometry_trial) {
    if (!has(UseOfSensor::kScan))
      add(Severity::kHint, why + ": the robot is located by the entities in view only", "");
    else
      add(recorded ? Severity::kWarning : Severity::kHint,
          why + ": dynemo-slam estimates it from the scans", "");
    return;
  }
  const auto& [scans, followed, warnings] = *log_.odometry_trial;
  if (scansFollow())
    return add(recorded && log_.frames_with_odometry == 0 ? Severity::kWarning : Severity::kHint,
               why + ": dynemo-slam estimates it from the scans, which does: " +
                   share(followed, scans) + " scans tried fit together",
               "");
  std::string reasons;
  for (const auto& [what, count] : warnings)
    reasons += (reasons.empty() ? " (" : ", ") + what + ": " + std::to_string(count);
  add(2 * followed >= scans ? Severity::kWarning : Severity::kError,
      why + ", and the scans alone do not do: " + share(followed, scans) +
          " scans tried fit together" + (reasons.empty() ? "" : reasons + ")"),
      "record odometry, or scans that follow each other faster and show more of the place");
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
                           what.find("image file not found") != std::string::npos ||
                           what.find("its clock is not that of") != std::string::npos ||
                           what.find("without odometry at its stamp") != std::string::npos;
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
