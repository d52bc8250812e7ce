#include "external_detector.h"

#include "dynemo/core/noise.h"
#include "stamp_compensation.h"

namespace dynemo {
namespace {

std::optional<SemanticClass> classNamed(const std::string& name) {
  for (const SemanticClass c : {SemanticClass::kObject, SemanticClass::kAgent}) {
    if (name == semanticClassName(c)) return c;
  }
  return std::nullopt;
}

}  // namespace

ExternalDetector::ExternalDetector(const PerceptionParams& params, const EntityModels& models)
    : params_(params.external), models_(models) {}

std::optional<EntityObservation> ExternalDetector::identify(const ExternalDetection& detection) {
  EntityObservation observation;
  observation.entity = detection.entity;
  const auto stated = classNamed(detection.class_name);
  if (!detection.class_name.empty() && !stated) {
    ++warnings_["unknown class '" + detection.class_name + "' of an external detection"];
  }
  if (const EntityModel* model = models_.findEntity(detection.entity)) {
    if (stated && *stated != model->semantic_class) {
      ++warnings_["class of an external detection differs from the entity file, which counts"];
    }
    observation.semantic_class = model->semantic_class;
    observation.name = model->name;
    return observation;
  }
  if (!stated) {
    ++warnings_[kUnknownEntityWarning];
    return std::nullopt;
  }
  observation.semantic_class = *stated;
  observation.name = detection.class_name + " " + std::to_string(detection.entity.value);
  return observation;
}

Matrix6 ExternalDetector::covarianceOf(const ExternalDetection& detection) {
  const Matrix6 by_default =
      isotropicCovariance(params_.default_sigma_translation_m, params_.default_sigma_rotation_rad);
  if (!detection.covariance) return by_default;
  if (detection.covariance->allFinite() && squareRootInformation(*detection.covariance)) {
    return *detection.covariance;
  }
  ++warnings_["covariance of an external detection is not positive definite: default used"];
  return by_default;
}

std::vector<EntityObservation> ExternalDetector::detect(const SensorFrame& frame) {
  std::map<std::pair<EntityId, std::string>, EntityObservation> found;
  for (const ExternalDetection& detection : frame.detections) {
    if (!detection.T_base_entity.isFinite()) {
      ++warnings_["external detection that is not finite"];
      continue;
    }
    auto observation = identify(detection);
    if (!observation) continue;
    const auto T_base_detection = motionFromFrame(frame, detection.stamp, detection.odometry);
    if (!T_base_detection) {
      ++warnings_["external detection without odometry: robot motion since the scan ignored"];
    }
    observation->stamp = detection.stamp;
    observation->T_base_entity = T_base_detection.value_or(Pose3()) * detection.T_base_entity;
    observation->covariance = covarianceOf(detection);
    observation->sensor_label = detection.sensor_label;
    if (!found.emplace(std::pair(detection.entity, detection.sensor_label), *observation).second) {
      ++warnings_["second external detection of an entity in a frame"];
    }
  }
  std::vector<EntityObservation> observations;
  for (auto& [key, observation] : found) observations.push_back(std::move(observation));
  return observations;
}

}  // namespace dynemo
