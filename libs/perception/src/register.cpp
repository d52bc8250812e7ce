#include "apriltag_detector.h"
#include "dynemo/perception/entity_detector.h"
#include "external_detector.h"

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

}  // namespace dynemo
