// What is in a rawlog, and whether dynemo-slam can run it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/ingest/ingest_params.h"
#include "dynemo/pipeline/params.h"
#include "dynemo/prep/tag_survey.h"

namespace dynemo {

enum class UseOfSensor { kScan, kImage, kOdometry, kDetections, kNotUsed };
const char* useText(UseOfSensor use);

struct ScanInspection {
  std::uint64_t min_points = 0, max_points = 0, sum_points = 0;
  /// Whether the points carry their own time.
  bool point_times = false;
};

struct CameraInspection {
  int width = 0, height = 0;  ///< of the calibration
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::string distortion;
  std::uint64_t embedded = 0, external = 0, external_missing = 0;
};

/// How far a clock is ahead of the one that the frames follow, as far as the order of the log
/// tells: the truth is within `uncertainty_s`, but for what one sensor takes longer than another to
/// be recorded.
struct ClockTie {
  double offset_s = 0.0, uncertainty_s = 0.0;
};

/// One sensor label with one class of observation.
struct SensorInspection {
  std::string label, class_name;
  UseOfSensor use = UseOfSensor::kNotUsed;
  std::uint64_t count = 0, without_stamp = 0;
  std::optional<Stamp> first, last;
  double median_interval_s = 0.0;
  /// Intervals of more than five times the median and 0.5 s.
  std::uint64_t gaps = 0;
  double longest_gap_s = 0.0;
  std::optional<Stamp> longest_gap_at;
  /// Steps back by more than SyncParams::sort_window_s.
  std::uint64_t jumps_back = 0;
  /// Where its stamps stand against those of the sensor that the frames follow; 0 for the same
  /// clock.
  double clock_offset_s = 0.0;
  bool other_clock = false;
  /// Empty for the same clock, and where nothing in the log ties the two.
  std::optional<ClockTie> clock_tie;
  std::optional<Pose3> T_base_sensor;  ///< the first observation's
  std::uint64_t pose_changes = 0;
  std::optional<ScanInspection> scan;
  std::optional<CameraInspection> camera;

  double rate_hz() const { return median_interval_s > 0 ? 1.0 / median_interval_s : 0.0; }
  double duration_s() const { return first ? secondsBetween(*first, *last) : 0.0; }
};

enum class Severity { kError, kWarning, kHint };
const char* severityText(Severity severity);

/// Something that keeps dynemo-slam from running, or that makes its result worse, and what to do.
struct Finding {
  Severity severity = Severity::kHint;
  std::string what, fix;
  /// The fix as commands for a shell, to be run where the log's path holds; empty when there is
  /// none, or when it needs what only its reader knows.
  std::string commands{};
};

/// LiDAR odometry on some of a log's scans.
struct OdometryTrialResult {
  std::uint64_t scans = 0, followed = 0;
  /// Why the others did not fit.
  std::map<std::string, std::uint64_t> warnings;
};

struct InspectionParams {
  IngestParams sensors;
  RobotOdometryParams odometry;
  TagSurveyParams tags;
  /// Images of each camera in which tags are searched.
  int tag_images = 40;
  /// Scans on which LiDAR odometry is tried where dynemo-slam would rely on it.
  int odometry_scans = 100;
};

struct Inspection {
  std::filesystem::path rawlog;
  std::uint64_t file_bytes = 0;
  bool compressed = false, actions_and_frames = false;
  std::uint64_t objects = 0, null_objects = 0;
  std::map<std::string, std::uint64_t> other_objects;
  std::string damage;
  std::vector<SensorInspection> sensors;  ///< by label, then class
  /// Of the observations by the clock of the sensor that the frames follow.
  std::optional<Stamp> first, last;
  /// What dynemo-slam makes of it.
  std::uint64_t frames = 0;
  /// Those with the log's odometry at their stamp.
  std::uint64_t frames_with_odometry = 0;
  std::optional<OdometryTrialResult> odometry_trial;
  std::map<std::string, std::uint64_t> ingest_warnings;
  std::uint64_t images_searched = 0;
  std::vector<SurveyedTag> tags;
  std::vector<Finding> findings;

  bool runnable() const;
};

/// Number of clocks that the stamps of the sensors come from.
std::size_t clockCount(const Inspection& inspection);

/// Reads the log twice: its objects, and as dynemo-slam reads it. Throws DataError when the file
/// cannot be read at all, and ConfigError for wrong parameters; what is wrong inside of the file is
/// a finding. Memory grows by 32 bytes per observation.
Inspection inspectRawlog(const std::filesystem::path& rawlog, const InspectionParams& params);

/// A table for people.
std::string inspectionText(const Inspection& inspection);
/// The same for programs.
std::string inspectionJson(const Inspection& inspection);

}  // namespace dynemo
