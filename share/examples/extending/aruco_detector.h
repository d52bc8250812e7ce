// An entity detector for ArUco markers.
#pragma once

#include <opencv2/aruco.hpp>

#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"

namespace dynemo {

/// The tags of the entity file are ArUco's, of one dictionary; an entity's markers are solved
/// together.
class ArucoDetector : public EntityDetector {
 public:
  ArucoDetector(const PerceptionParams& params, const EntityModels& models);
  std::vector<EntityObservation> detect(const SensorFrame& frame) override;

 private:
  std::map<EntityId, std::vector<TagCornerObservation>> findMarkers(const CameraImage& image);
  std::optional<PoseMinimum> solve(const EntityModel& model, const CameraImage& image,
                                   const std::vector<TagCornerObservation>& markers);

  const PerceptionParams params_;
  const EntityModels& models_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
};

}  // namespace dynemo
