#pragma once

#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"

namespace dynemo {

/// Entity poses that another program measured and the frame brings along.
class ExternalDetector : public EntityDetector {
 public:
  ExternalDetector(const PerceptionParams& params, const EntityModels& models);
  std::vector<EntityObservation> detect(const SensorFrame& frame) override;

 private:
  /// Class and name; empty when neither the models nor the detection tell the class.
  std::optional<EntityObservation> identify(const ExternalDetection& detection);
  Matrix6 covarianceOf(const ExternalDetection& detection);

  const ExternalDetectorParams params_;
  const EntityModels& models_;
};

}  // namespace dynemo
