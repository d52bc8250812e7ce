// A copy of a rawlog with the entity detections inside.
#pragma once

#include <cstdint>
#include <filesystem>

#include "dynemo/ingest/ingest_params.h"
#include "dynemo/perception/perception_params.h"
#include "dynemo/prep/rewrite.h"

namespace dynemo {

struct AnnotateParams {
  IngestParams sensors{};
  PerceptionParams perception{};
  /// Leave the images out of the copy: what was to be seen in them is in the detections.
  bool drop_images = false;
};

struct AnnotateReport : RewriteReport {
  std::uint64_t images = 0;      ///< searched
  std::uint64_t detections = 0;  ///< entity poses written
};

/// Runs the detectors of dynemo-slam that look at images (perception.detectors without "external")
/// over the frames that it would see, and stores what they find as CObservation6DFeatures after
/// each image: label "<camera>_entities", sensor pose of the camera, feature id = entity id, pose
/// T_camera_entity, information of (x, y, z, yaw, pitch, roll). Later runs need the entity file for
/// the classes, but no camera. Throws as rewrite.h and DataError when the log has no image.
AnnotateReport annotateRawlog(const std::filesystem::path& input,
                              const std::filesystem::path& output, const EntityModels& models,
                              const AnnotateParams& params, const RewriteOptions& options);

}  // namespace dynemo
