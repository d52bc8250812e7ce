// A simulated sample recording together with its ground truth, read frame by frame for tests of
// single stages.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/perception/entity_model.h"

namespace dynemo::test {

/// Axis-aligned in the entity's frame [m].
struct EntityBox {
  Vector3 min, max;
};

/// Ground truth poses, linear between rows.
class SampleTruth {
 public:
  SampleTruth(const std::filesystem::path& folder, const std::string& name);
  /// Empty outside of the recorded span.
  std::optional<Pose3> T_world_base(Stamp stamp) const;
  std::optional<Pose3> T_world_entity(EntityId entity, Stamp stamp) const;
  std::optional<Pose3> T_base_entity(EntityId entity, Stamp stamp) const;
  const std::map<EntityId, EntityBox>& boxes() const { return boxes_; }

 private:
  using Track = std::map<Stamp, Pose3>;
  static std::optional<Pose3> at(const Track& track, Stamp stamp);
  Track robot_;
  std::map<EntityId, Track> entities_;
  std::map<EntityId, EntityBox> boxes_;
};

/// Image frames of a sample: each image with the scan of the same stamp and the 3-D odometry there.
class SampleFrames {
 public:
  SampleFrames(const std::filesystem::path& folder, const std::string& name);
  ~SampleFrames();
  std::optional<SensorFrame> next();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The folder named by DYNEMO_SAMPLES.
std::optional<std::filesystem::path> samplesFolder();
/// The folder named by DYNEMO_REAL_DATA.
std::optional<std::filesystem::path> realDataFolder();

}  // namespace dynemo::test
