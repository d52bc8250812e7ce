#include "apriltag_detector.h"

#include <cmath>

#include "dynemo/core/noise.h"
#include "stamp_compensation.h"

namespace dynemo {

AprilTagDetector::AprilTagDetector(const PerceptionParams& params, const EntityModels& models)
    : params_(params), models_(models), finder_(models.tagFamily(), params.tag_finder) {}

bool AprilTagDetector::usable(const CameraImage& image) {
  if (image.grey.empty() || image.grey.type() != CV_8UC1) {
    ++warnings_["image without pixels"];
  } else if (!image.model.valid()) {
    ++warnings_["image without camera calibration"];
  } else if (image.grey.cols != image.model.width || image.grey.rows != image.model.height) {
    ++warnings_["image size differs from the camera calibration"];
  } else {
    return true;
  }
  return false;
}

AprilTagDetector::TagsByEntity AprilTagDetector::findTags(const CameraImage& image) {
  TagsByEntity by_entity;
  std::optional<int> previous;
  for (const FoundTag& tag : finder_.find(image.grey)) {
    // Found tags come in order of id, the best of each first: the others are second prints or
    // false.
    const int id = tag.observation.tag_id;
    if (previous == id) {
      ++warnings_["tag id seen twice in one image"];
      continue;
    }
    previous = id;
    const auto [entity, tag_model] = models_.findTag(id);
    if (entity) {
      by_entity[entity->id].push_back(tag.observation);
    } else {
      ++warnings_["unknown tag id"];
    }
  }
  return by_entity;
}

OrientationPrior AprilTagDetector::priorOf(EntityId entity, const CameraImage& image) const {
  OrientationPrior prior;
  const Matrix3 R_camera_base = image.T_base_camera.R.transpose();
  if (params_.ambiguity.entities_are_upright) {
    // Odometry starts levelled; without it the robot is taken to stand level itself.
    const Vector3 up_base = image.odometry
                                ? Vector3(image.odometry->T_odom_base.R.row(2).transpose())
                                : Vector3::UnitZ();
    prior.up_camera = R_camera_base * up_base;
  }
  const auto it = memory_.find(entity);
  if (it != memory_.end() && image.odometry &&
      std::abs(secondsBetween(it->second.stamp, image.stamp)) <=
          params_.ambiguity.prediction_max_age_s) {
    prior.R_camera_entity =
        R_camera_base * image.odometry->T_odom_base.R.transpose() * it->second.R_odom_entity;
  }
  return prior;
}

void AprilTagDetector::remember(EntityId entity, const CameraImage& image,
                                const ResolvedPose& resolved) {
  if (!image.odometry || !resolved.decided_without_prediction) return;
  memory_[entity] = {image.stamp, image.odometry->T_odom_base.R * image.T_base_camera.R *
                                      resolved.pose.T_camera_entity.R};
}

std::optional<EntityObservation> AprilTagDetector::observe(
    const EntityModel& model, const CameraImage& image, const Pose3& T_base_image,
    std::span<const TagCornerObservation> tags) {
  const auto solution = solveEntityPose(model, image.model, tags, params_.tag_pose);
  if (!solution) {
    ++warnings_[text(solution.error())];
    return std::nullopt;
  }
  if (!solution->rejected_tags.empty()) ++warnings_["tag contradicts the others of its entity"];
  const auto resolved = resolveAmbiguity(*solution, priorOf(model.id, image), params_.ambiguity);
  if (!resolved) {
    ++warnings_[text(resolved.error())];
    return std::nullopt;
  }
  remember(model.id, image, *resolved);

  EntityObservation observation;
  observation.entity = model.id;
  observation.semantic_class = model.semantic_class;
  observation.name = model.name;
  observation.stamp = image.stamp;
  observation.T_base_entity =
      (T_base_image * image.T_base_camera * resolved->pose.T_camera_entity).normalized();
  observation.covariance = floorCovariance(
      resolved->pose.covariance, params_.min_sigma_translation_m, params_.min_sigma_rotation_rad);
  observation.reprojection_rms_px = resolved->pose.reprojection_rms_px;
  observation.tag_count = static_cast<int>(solution->used_tags.size());
  observation.sensor_label = image.label;
  return observation;
}

std::vector<EntityObservation> AprilTagDetector::detect(const SensorFrame& frame) {
  std::map<std::pair<EntityId, std::string>, EntityObservation> found;
  for (const CameraImage& image : frame.images) {
    if (!usable(image)) continue;
    const auto T_base_image = motionFromFrame(frame, image.stamp, image.odometry);
    if (!T_base_image) ++warnings_["image without odometry: robot motion since the scan ignored"];
    for (const auto& [entity, tags] : findTags(image)) {
      auto observation =
          observe(*models_.findEntity(entity), image, T_base_image.value_or(Pose3()), tags);
      if (!observation) continue;
      if (!found.emplace(std::pair(entity, image.label), std::move(*observation)).second) {
        ++warnings_["second image of one camera in a frame"];
      }
    }
  }
  std::vector<EntityObservation> observations;
  for (auto& [key, observation] : found) observations.push_back(std::move(observation));
  return observations;
}

}  // namespace dynemo
