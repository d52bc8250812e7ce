#pragma once

#include <map>
#include <span>

#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"
#include "dynemo/perception/tag_finder.h"

namespace dynemo {

/// Entities by their AprilTags: one pose per entity and image from all of its visible tags.
class AprilTagDetector : public EntityDetector {
 public:
  AprilTagDetector(const PerceptionParams& params, const EntityModels& models);
  std::vector<EntityObservation> detect(const SensorFrame& frame) override;

 private:
  using TagsByEntity = std::map<EntityId, std::vector<TagCornerObservation>>;
  /// The last observation that needed no prediction itself.
  struct Memory {
    Stamp stamp;
    Matrix3 R_odom_entity;
  };

  bool usable(const CameraImage& image);
  TagsByEntity findTags(const CameraImage& image);
  std::optional<EntityObservation> observe(const EntityModel& model, const CameraImage& image,
                                           const Pose3& T_base_image,
                                           std::span<const TagCornerObservation> tags);
  OrientationPrior priorOf(EntityId entity, const CameraImage& image) const;
  void remember(EntityId entity, const CameraImage& image, const ResolvedPose& resolved);

  const PerceptionParams params_;
  const EntityModels& models_;
  TagFinder finder_;
  std::map<EntityId, Memory> memory_;
};

}  // namespace dynemo
