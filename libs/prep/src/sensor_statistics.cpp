#include "sensor_statistics.h"

#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/typemeta/TEnumType.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/decoders.h"
#include "dynemo/ingest/external_files.h"
#include "dynemo/ingest/rawlog_reader.h"
#include "dynemo/prep/external_references.h"

namespace dynemo {
namespace {

using namespace mrpt::obs;

constexpr double kGapIntervals = 5.0, kShortestGap_s = 0.5;
/// Stamps that are further from the others than this come from another clock.
constexpr double kOtherClock_s = 2.0;

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

UseOfSensor useOf(const CObservation& o) {
  if (decoders().scans.find(o) >= 0) return UseOfSensor::kScan;
  if (decoders().images.find(o) >= 0) return UseOfSensor::kImage;
  if (decoders().odometry.find(o) >= 0) return UseOfSensor::kOdometry;
  if (decoders().detections.find(o) >= 0) return UseOfSensor::kDetections;
  return UseOfSensor::kNotUsed;
}

/// Number of points as far as it is stored in the rawlog itself.
std::optional<std::uint64_t> pointCount(const CObservation& o) {
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&o))
    return cloud->pointcloud ? std::optional(cloud->pointcloud->size()) : std::nullopt;
  if (const auto* range = dynamic_cast<const CObservation3DRangeScan*>(&o))
    return static_cast<std::uint64_t>(range->rangeImage.size());
  if (const auto* rotating = dynamic_cast<const CObservationRotatingScan*>(&o))
    return static_cast<std::uint64_t>(rotating->rangeImage.size());
  if (const auto* velodyne = dynamic_cast<const CObservationVelodyneScan*>(&o))
    return velodyne->scan_packets.size() * CObservationVelodyneScan::BLOCKS_PER_PACKET *
           CObservationVelodyneScan::SCANS_PER_BLOCK;
  return std::nullopt;
}

const mrpt::img::TCamera* calibrationOf(const CObservation& o) {
  if (const auto* image = dynamic_cast<const CObservationImage*>(&o)) return &image->cameraParams;
  if (const auto* range = dynamic_cast<const CObservation3DRangeScan*>(&o))
    return range->hasIntensityImage ? &range->cameraParamsIntensity : nullptr;
  return nullptr;
}

CameraInspection cameraInspection(const mrpt::img::TCamera& camera) {
  CameraInspection c;
  c.width = static_cast<int>(camera.ncols);
  c.height = static_cast<int>(camera.nrows);
  c.fx = camera.fx();
  c.fy = camera.fy();
  c.cx = camera.cx();
  c.cy = camera.cy();
  c.distortion =
      mrpt::typemeta::TEnumType<mrpt::img::DistortionModel>::value2name(camera.distortion);
  return c;
}

/// The stamps of one sensor in the order of the file, each with its place in it.
using StoredStamps = std::vector<std::pair<std::uint64_t, Stamp>>;

/// One sensor while the log is read.
struct Statistics {
  SensorInspection sensor;
  std::vector<double> intervals_s, offsets_s;
  StoredStamps stored;
  std::optional<Stamp> previous;

  void takeStamp(Stamp stamp, double sort_window_s);
  void takePose(const CObservation& o);
  void takeContent(const CObservation& o, const ExternalFiles& files);
  void finish(const Statistics* reference);

 private:
  /// Where its clock stands against the reference's.
  double clockOffset(const Statistics& reference) const;
};

void Statistics::takeStamp(Stamp stamp, double sort_window_s) {
  if (!sensor.first || stamp < *sensor.first) sensor.first = stamp;
  if (!sensor.last || stamp > *sensor.last) sensor.last = stamp;
  if (previous) {
    const double step_s = secondsBetween(*previous, stamp);
    if (step_s < -sort_window_s) ++sensor.jumps_back;
    if (step_s > 0) intervals_s.push_back(step_s);
    if (step_s > sensor.longest_gap_s) {
      sensor.longest_gap_s = step_s;
      sensor.longest_gap_at = previous;
    }
  }
  previous = stamp;
}

void Statistics::takePose(const CObservation& o) {
  mrpt::poses::CPose3D pose;
  o.getSensorPose(pose);
  const Pose3 T = fromMrpt(pose);
  if (!isPlausible(T)) return;
  if (!sensor.T_base_sensor)
    sensor.T_base_sensor = T;
  else if (local(*sensor.T_base_sensor, T).norm() > 1e-6)
    ++sensor.pose_changes;
}

void Statistics::takeContent(const CObservation& o, const ExternalFiles& files) {
  if (sensor.use == UseOfSensor::kScan) {
    if (!sensor.scan) sensor.scan.emplace();
    sensor.scan->point_times = dynamic_cast<const CObservationVelodyneScan*>(&o) != nullptr ||
                               dynamic_cast<const CObservationRotatingScan*>(&o) != nullptr;
    if (const auto points = pointCount(o)) {
      ScanInspection& s = *sensor.scan;
      s.min_points = sensor.count == 1 ? *points : std::min(s.min_points, *points);
      s.max_points = std::max(s.max_points, *points);
      s.sum_points += *points;
    }
  }
  if (const auto* calibration = calibrationOf(o)) {
    if (!sensor.camera) sensor.camera = cameraInspection(*calibration);
    const auto names = externalFiles(o);
    ++(names.empty() ? sensor.camera->embedded : sensor.camera->external);
    for (const std::string& name : names)
      if (!files.find(name)) ++sensor.camera->external_missing;
  }
}

double Statistics::clockOffset(const Statistics& reference) const {
  if (!sensor.first) return 0.0;
  const bool disjoint =
      *sensor.first > *reference.sensor.last || *sensor.last < *reference.sensor.first;
  const auto [low, high] = std::minmax_element(offsets_s.begin(), offsets_s.end());
  // A log that was sorted by stamps says nothing of what was recorded when: both are taken to have
  // begun together.
  if (disjoint && (offsets_s.empty() || *high - *low > kOtherClock_s))
    return secondsBetween(*reference.sensor.first, *sensor.first);
  // Where the reference is silent the other goes on: only a clock of its own is never close.
  const double closest_s = offsets_s.empty() ? 0.0 : std::min(std::abs(*low), std::abs(*high));
  const bool crosses = !offsets_s.empty() && *low <= 0.0 && *high >= 0.0;
  return crosses || closest_s < kOtherClock_s ? 0.0 : median(offsets_s);
}

void Statistics::finish(const Statistics* reference) {
  sensor.median_interval_s = median(intervals_s);
  if (reference && reference != this) sensor.clock_offset_s = clockOffset(*reference);
  sensor.other_clock =
      std::abs(sensor.clock_offset_s) > kOtherClock_s + 2.0 * sensor.median_interval_s;
  // Detections are events: there are none where nothing is to be seen.
  if (sensor.use == UseOfSensor::kDetections) {
    sensor.longest_gap_s = 0.0;
    sensor.longest_gap_at.reset();
    return;
  }
  const double limit_s = std::max(kShortestGap_s, kGapIntervals * sensor.median_interval_s);
  sensor.gaps = static_cast<std::uint64_t>(
      std::count_if(intervals_s.begin(), intervals_s.end(), [&](double i) { return i > limit_s; }));
}

/// How far the clock of `other` is ahead of that of `known`, by the order in which a log stores
/// what it gets: what is stored between two observations of `known` was got between them. Empty
/// when too little of it was, as when the two were recorded one after the other, or when the log
/// was sorted by stamps.
std::optional<ClockTie> clockTie(const StoredStamps& other, const StoredStamps& known) {
  constexpr std::size_t kFewest = 5;
  double low_s = -std::numeric_limits<double>::infinity(), high_s = -low_s;
  std::size_t between = 0, next = 0;
  for (const auto& [place, stamp] : other) {
    while (next < known.size() && known[next].first < place) ++next;
    if (next == 0 || next == known.size()) continue;
    ++between;
    low_s = std::max(low_s, secondsBetween(known[next].second, stamp));
    high_s = std::min(high_s, secondsBetween(known[next - 1].second, stamp));
  }
  if (between < kFewest || 2 * between < std::min(other.size(), known.size())) return std::nullopt;
  return ClockTie{0.5 * (low_s + high_s), 0.5 * std::abs(high_s - low_s)};
}

using StatisticsBySensor = std::map<std::pair<std::string, std::string>, Statistics>;

/// Takes all observations in the order of the file.
class Collector {
 public:
  Collector(const std::filesystem::path& rawlog, const InspectionParams& params,
            Inspection& inspection)
      : files_(rawlog), params_(params), inspection_(inspection) {}

  void take(const RawlogEntry& entry) {
    using Kind = RawlogEntry::Kind;
    ++inspection_.objects;
    switch (entry.kind) {
      case Kind::kObservation:
        return observation(dynamic_cast<const CObservation&>(*entry.object));
      case Kind::kSensoryFrame:
        inspection_.actions_and_frames = true;
        for (const auto& o : dynamic_cast<const CSensoryFrame&>(*entry.object))
          if (o) observation(*o);
        return;
      case Kind::kActions:
        inspection_.actions_and_frames = true;
        ++inspection_.other_objects["CActionCollection"];
        return;
      case Kind::kNull:
        ++inspection_.null_objects;
        return;
      case Kind::kOther:
        ++inspection_.other_objects[entry.class_name];
    }
  }

  void finish() {
    for (auto& [key, statistics] : sensors_) statistics.finish(reference_);
    for (auto& [key, statistics] : sensors_) {
      if (statistics.sensor.other_clock) tie(statistics);
      const SensorInspection& s = statistics.sensor;
      inspection_.sensors.push_back(s);
      if (s.other_clock) continue;
      if (s.first && (!inspection_.first || *s.first < *inspection_.first))
        inspection_.first = s.first;
      if (s.last && (!inspection_.last || *s.last > *inspection_.last)) inspection_.last = s.last;
    }
  }

 private:
  /// By the sensor of the main clock that does it best.
  void tie(Statistics& other) const {
    for (const auto& [key, known] : sensors_) {
      if (known.sensor.other_clock) continue;
      const auto tie = clockTie(other.stored, known.stored);
      std::optional<ClockTie>& best = other.sensor.clock_tie;
      if (tie && (!best || tie->uncertainty_s < best->uncertainty_s)) best = tie;
    }
    if (other.sensor.clock_tie) other.sensor.clock_offset_s = other.sensor.clock_tie->offset_s;
  }
  void observation(const CObservation& o) {
    Statistics& s = sensors_[{o.sensorLabel, shortClassName(o)}];
    s.sensor.label = o.sensorLabel;
    s.sensor.class_name = shortClassName(o);
    s.sensor.use = useOf(o);
    ++s.sensor.count;
    s.takePose(o);
    s.takeContent(o, files_);
    const auto stamp = validStamp(o.timestamp);
    if (!stamp) {
      ++s.sensor.without_stamp;
      return;
    }
    s.takeStamp(*stamp, params_.sensors.sync.sort_window_s);
    s.stored.emplace_back(inspection_.objects, *stamp);
    // The clock of the first sensor of the best use seen so far.
    if (!reference_ || s.sensor.use < reference_->sensor.use) {
      reference_ = &s;
      for (auto& [key, other] : sensors_) other.offsets_s.clear();
    }
    if (&s != reference_ && reference_->previous)
      s.offsets_s.push_back(secondsBetween(*reference_->previous, *stamp));
  }

  ExternalFiles files_;
  const InspectionParams& params_;
  Inspection& inspection_;
  StatisticsBySensor sensors_;
  Statistics* reference_ = nullptr;
};

}  // namespace

void inspectObjects(const std::filesystem::path& rawlog, const InspectionParams& params,
                    Inspection& inspection) {
  RawlogReader reader(rawlog, static_cast<std::size_t>(params.sensors.max_object_mb * 1e6));
  inspection.rawlog = rawlog;
  inspection.file_bytes = std::filesystem::file_size(rawlog);
  inspection.compressed = reader.compressed();
  Collector collector(rawlog, params, inspection);
  while (const auto entry = reader.next()) collector.take(*entry);
  inspection.damage = reader.damage();
  collector.finish();
}

}  // namespace dynemo
