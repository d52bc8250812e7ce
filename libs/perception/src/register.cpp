#include "apriltag_detector.h"
#include "dynemo/perception/entity_detector.h"
#include "external_detector.h"
#include "plane_extractors.h"

namespace dynemo {

const DetectorRegistry& entityDetectors() {
  static const DetectorRegistry registry = [] {
    DetectorRegistry table("entity detector");
    table.add("apriltag", [](const PerceptionParams& params, const EntityModels& models) {
      return std::make_unique<AprilTagDetector>(params, models);
    });
    table.add("external", [](const PerceptionParams& params, const EntityModels& models) {
      return std::make_unique<ExternalDetector>(params, models);
    });
    return table;
  }();
  return registry;
}

const PlaneExtractorRegistry& planeExtractors() {
  static const PlaneExtractorRegistry registry = [] {
    PlaneExtractorRegistry table("plane extractor");
    table.add("range_image",
              [](const PlaneParams& params) { return std::make_unique<RangeImagePlanes>(params); });
    table.add("ransac",
              [](const PlaneParams& params) { return std::make_unique<RansacPlanes>(params); });
    return table;
  }();
  return registry;
}

}  // namespace dynemo
