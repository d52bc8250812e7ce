#include "dynemo/prep/inspection.h"

#include <algorithm>
#include <cmath>

#include "dynemo/core/error.h"
#include "dynemo/ingest/rawlog_source.h"
#include "odometry_trial.h"
#include "sensor_statistics.h"

namespace dynemo {
namespace {

/// Which images are searched for tags: evenly spread over each camera's.
class ImageSample {
 public:
  ImageSample(const Inspection& inspection, int images_per_camera) {
    for (const SensorInspection& s : inspection.sensors)
      if (s.camera)
        step_[s.label] = std::max<std::uint64_t>(
            1, s.count / static_cast<std::uint64_t>(std::max(1, images_per_camera)));
    none_ = images_per_camera == 0;
  }
  /// Removes from the frame the images that are not in the sample.
  void thin(SensorFrame& frame) {
    std::erase_if(frame.images, [&](const CameraImage& image) {
      const auto step = step_.find(image.label);
      return none_ || step == step_.end() || seen_[image.label]++ % step->second != 0;
    });
  }

 private:
  std::map<std::string, std::uint64_t> step_, seen_;
  bool none_ = false;
};

std::uint64_t scansOf(const Inspection& inspection, const LidarParams& lidar) {
  std::uint64_t count = 0;
  for (const SensorInspection& s : inspection.sensors)
    if (s.use == UseOfSensor::kScan && (lidar.label.empty() || s.label == lidar.label))
      count += s.count;
  return count;
}

/// Reads the log as dynemo-slam does. A choice that is left open, or nothing usable, is a finding.
void inspectFrames(const std::filesystem::path& rawlog, const InspectionParams& params,
                   Inspection& inspection) {
  TagSurvey survey(params.tags);
  ImageSample sample(inspection, params.tag_images);
  try {
    const auto source = makeRawlogSource(params.sensors, rawlog);
    OdometryTrial trial(params, source->hasOdometry(), scansOf(inspection, params.sensors.lidar));
    while (auto frame = source->next()) {
      inspection.frames_with_odometry += frame->odometry ? 1 : 0;
      sample.thin(*frame);
      survey.add(*frame);
      trial.add(*frame);
    }
    inspection.odometry_trial = trial.result();
    inspection.frames = source->report().frames;
    inspection.ingest_warnings = source->report().warnings;
  } catch (const ConfigError& e) {
    const std::string why = e.what();
    inspection.findings.push_back({Severity::kError, why,
                                   why.starts_with("odometry.source")
                                       ? "leave odometry.source as it is by default"
                                       : "choose with --set here and for dynemo-slam, or rename or "
                                         "remove sensors: dynemo-prep "
                                         "relabel, rawlog-edit --remove-label"});
  } catch (const DataError& e) {
    const std::string why = e.what();
    const bool named = why.find("of the configured sensor") != std::string::npos;
    inspection.findings.push_back(
        {Severity::kError, why,
         named ? "name sensors that are there, or none: they are found by themselves when there is "
                 "only one of a kind"
         : inspection.objects == 0 && !inspection.damage.empty()
             ? "record or copy it again"
             : "dynemo-slam needs scans, images with tags, entity detections or odometry, as "
               "CObservationPointCloud, CObservationImage, CObservation6DFeatures, "
               "CObservationRobotPose, …"});
  }
  inspection.images_searched = survey.imagesSearched();
  inspection.tags = survey.tags();
}

}  // namespace

const char* useText(UseOfSensor use) {
  switch (use) {
    case UseOfSensor::kScan:
      return "scan";
    case UseOfSensor::kImage:
      return "image";
    case UseOfSensor::kOdometry:
      return "odometry";
    case UseOfSensor::kDetections:
      return "detections";
    case UseOfSensor::kNotUsed:
      break;
  }
  return "not used";
}

const char* severityText(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "error";
    case Severity::kWarning:
      return "warning";
    case Severity::kHint:
      break;
  }
  return "hint";
}

std::size_t clockCount(const Inspection& inspection) {
  constexpr double kSameClock_s = 2.0;
  std::vector<double> offsets_s = {0.0};
  for (const SensorInspection& s : inspection.sensors) {
    const bool known = std::any_of(offsets_s.begin(), offsets_s.end(), [&](double offset_s) {
      return std::abs(offset_s - s.clock_offset_s) < kSameClock_s;
    });
    if (s.other_clock && !known) offsets_s.push_back(s.clock_offset_s);
  }
  return offsets_s.size();
}

bool Inspection::runnable() const {
  return std::none_of(findings.begin(), findings.end(),
                      [](const Finding& f) { return f.severity == Severity::kError; });
}

Inspection inspectRawlog(const std::filesystem::path& rawlog, const InspectionParams& params) {
  extrinsicsTable(params.sensors);  // wrong ones are the caller's error, not the log's
  Inspection inspection;
  inspectObjects(rawlog, params, inspection);
  inspectFrames(rawlog, params, inspection);
  judge(params, inspection);
  std::stable_sort(inspection.findings.begin(), inspection.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
  return inspection;
}

}  // namespace dynemo
