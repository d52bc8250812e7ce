#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dynemo/core/registry.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/perception/entity_model.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

struct PerceptionParams;

/// What detectors call a detection that is left out because neither it nor the entity file says
/// what its entity is.
inline constexpr const char* kUnknownEntityWarning = "detection of an entity that is not described";

/// Finds entities in a frame. Implementations may keep what they saw last to resolve ambiguities.
class EntityDetector {
 public:
  virtual ~EntityDetector() = default;
  /// Observations ordered by entity id, then sensor label; at most one per entity and sensor.
  virtual std::vector<EntityObservation> detect(const SensorFrame& frame) = 0;
  /// What was left out and why, e.g. "unknown tag id", "ambiguous pose".
  const std::map<std::string, std::uint64_t>& warnings() const { return warnings_; }

 protected:
  std::map<std::string, std::uint64_t> warnings_;
};

/// Detectors by name: "apriltag", "external". The models must outlive the detector.
using DetectorRegistry = Registry<EntityDetector, const PerceptionParams&, const EntityModels&>;
const DetectorRegistry& entityDetectors();

}  // namespace dynemo
