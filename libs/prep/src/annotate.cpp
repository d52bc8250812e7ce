#include "dynemo/prep/annotate.h"

#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservation6DFeatures.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/perception/entity_detector.h"
#include "rewriting.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

using mrpt::obs::CObservation6DFeatures;

constexpr const char* kLabelSuffix = "_entities";

/// Entities seen in one image.
struct ImageDetections {
  Pose3 T_base_camera;
  std::vector<EntityObservation> observations;
  bool written = false;
};
/// By stamp and label of the image.
using DetectionTable = std::map<std::pair<Stamp, std::string>, ImageDetections>;

class ImageDetectors {
 public:
  ImageDetectors(const PerceptionParams& params, const EntityModels& models) {
    for (const std::string& name : params.detectors)
      if (name != "external") detectors_.push_back(entityDetectors().make(name, params, models));
    if (detectors_.empty())
      throw ConfigError("perception.detectors: names no detector that looks at images");
  }

  /// In the frame of the image alone, so that the poses belong to its own stamp.
  ImageDetections detect(const CameraImage& image) {
    SensorFrame frame;
    frame.stamp = image.stamp;
    frame.odometry = image.odometry;
    frame.images = {image};
    ImageDetections all{image.T_base_camera, {}, false};
    for (const auto& detector : detectors_)
      for (auto& found : detector->detect(frame)) all.observations.push_back(std::move(found));
    return all;
  }

  void countWarnings(WarningCounter& warnings) const {
    for (const auto& detector : detectors_)
      for (const auto& [what, times] : detector->warnings()) warnings.count(what, times);
  }

 private:
  std::vector<std::unique_ptr<EntityDetector>> detectors_;
};

DetectionTable detectAll(const fs::path& input, const EntityModels& models,
                         const AnnotateParams& params, WarningCounter& warnings,
                         AnnotateReport& report) {
  ImageDetectors detectors(params.perception, models);
  DetectionTable table;
  const auto source = makeRawlogSource(params.sensors, input);
  while (const auto frame = source->next()) {
    for (const CameraImage& image : frame->images) {
      ++report.images;
      auto found = detectors.detect(image);
      report.detections += found.observations.size();
      if (!found.observations.empty()) table[{image.stamp, image.label}] = std::move(found);
    }
  }
  detectors.countWarnings(warnings);
  for (const auto& [what, times] : source->report().warnings) warnings.count(what, times);
  if (report.images == 0) throw DataError(input.string() + ": holds no image that can be used");
  return table;
}

CObservation6DFeatures featuresOf(const std::pair<Stamp, std::string>& key,
                                  const ImageDetections& found) {
  CObservation6DFeatures features;
  features.timestamp = toMrpt(key.first);
  features.sensorLabel = key.second + kLabelSuffix;
  features.sensorPose = toMrpt(found.T_base_camera);
  for (const EntityObservation& observation : found.observations) {
    auto& feature = features.sensedFeatures.emplace_back();
    const Pose3 T_camera_entity = found.T_base_camera.inverse() * observation.T_base_entity;
    feature.id = static_cast<std::int32_t>(observation.entity.value);
    feature.pose = toMrpt(T_camera_entity);
    // The right tangent does not change when the pose is moved to another parent frame.
    const auto covariance = covarianceToMrpt(T_camera_entity, observation.covariance);
    if (const auto information = invertSpd(covariance.asEigen().eval()))
      feature.inf_matrix.asEigen() = *information;
  }
  return features;
}

bool isImage(const mrpt::obs::CObservation& o) {
  return dynamic_cast<const mrpt::obs::CObservationImage*>(&o) != nullptr;
}

/// Puts the features of the images of a sensory frame into that frame.
void annotateFrame(StoredObject& stored, const std::vector<CObservation6DFeatures>& features) {
  auto& frame = dynamic_cast<mrpt::obs::CSensoryFrame&>(*stored.entry.object);
  for (const auto& f : features) frame.insert(std::make_shared<CObservation6DFeatures>(f));
  stored.edited = stored.edited || !features.empty();
}

}  // namespace

AnnotateReport annotateRawlog(const fs::path& input, const fs::path& output,
                              const EntityModels& models, const AnnotateParams& params,
                              const RewriteOptions& options) {
  AnnotateReport report;
  WarningCounter warnings;
  PieceReader reader(input, warnings);
  RawlogOutput out(output, options.compressed.value_or(reader.compressed()), options.images);
  DetectionTable table = detectAll(input, models, params, warnings, report);
  const ExternalFiles files(input);

  while (auto piece = reader.next()) {
    report.read += piece->objects.size();
    std::vector<CObservation6DFeatures> features;
    forEachObservation(*piece, [&](mrpt::obs::CObservation& o) {
      const auto stamp = validStamp(o.timestamp);
      const auto found = stamp ? table.find({*stamp, o.sensorLabel}) : table.end();
      if (found == table.end() || found->second.written) return;
      if (dynamic_cast<mrpt::obs::CObservation3DRangeScan*>(&o) == nullptr && !isImage(o)) return;
      features.push_back(featuresOf(found->first, found->second));
      found->second.written = true;
    });
    if (StoredObject& last = piece->objects.back();
        last.entry.kind == RawlogEntry::Kind::kSensoryFrame) {
      annotateFrame(last, features);
      features.clear();
    }
    const bool kept = !params.drop_images || editObservations(*piece, [](auto& o) {
      return isImage(o) ? EditResult::kDropped : EditResult::kUnchanged;
    });
    if (kept) out.write(std::move(*piece), files, warnings);
    for (const auto& f : features) out.write(f);
  }
  const auto lost = std::count_if(table.begin(), table.end(),
                                  [](const auto& row) { return !row.second.written; });
  warnings.count("detections of an image whose stamp was changed on reading left out",
                 static_cast<std::uint64_t>(lost));
  out.commit();
  report.written = out.objectsWritten();
  report.warnings = warnings.counts();
  report.files = {output};
  return report;
}

}  // namespace dynemo
