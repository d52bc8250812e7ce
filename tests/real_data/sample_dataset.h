// A simulated sample recording together with its ground truth, read frame by frame for tests of
// single stages.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/plane3.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/perception/entity_model.h"

namespace dynemo::test {

/// Axis-aligned in the entity's frame [m].
struct EntityBox {
  Vector3 min, max;
};

/// One face of a wall, floor or ceiling.
struct TruePlane {
  std::string name;
  Plane3 plane_world;  ///< the normal towards the free side
  /// Walls: the end points of the wall's middle line, and its heights.
  Vector2 from = Vector2::Zero(), to = Vector2::Zero();
  double z_min_m = 0.0, z_max_m = 0.0;
  bool isWall() const { return name.starts_with("wall"); }
  /// Whether a point of the world is on the face.
  bool contains(const Vector3& p, double tolerance_m) const;
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
  const std::vector<TruePlane>& planes() const { return planes_; }

 private:
  using Track = std::map<Stamp, Pose3>;
  static std::optional<Pose3> at(const Track& track, Stamp stamp);
  Track robot_;
  std::map<EntityId, Track> entities_;
  std::map<EntityId, EntityBox> boxes_;
  std::vector<TruePlane> planes_;
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
