#include "aruco_detector.h"

#include "dynemo/core/noise.h"
#include "stamp_compensation.h"

namespace dynemo {

ArucoDetector::ArucoDetector(const PerceptionParams& params, const EntityModels& models)
    : params_(params),
      models_(models),
      dictionary_(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_250)) {}

std::map<EntityId, std::vector<TagCornerObservation>> ArucoDetector::findMarkers(
    const CameraImage& image) {
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> corners;
  const auto options = cv::aruco::DetectorParameters::create();
  options->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  cv::aruco::detectMarkers(image.grey, dictionary_, corners, ids, options);

  std::map<EntityId, std::vector<TagCornerObservation>> by_entity;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const EntityModel* entity = models_.findTag(ids[i]).first;
    if (!entity) {
      ++warnings_["unknown marker id"];
      continue;
    }
    // ArUco starts at the upper left and goes clockwise, TagModel::corners() at the lower left and
    // counter-clockwise.
    TagCornerObservation marker{ids[i], {}};
    for (std::size_t k = 0; k < 4; ++k)
      marker.corners_px[k] = Vector2(corners[i][3 - k].x, corners[i][3 - k].y);
    by_entity[entity->id].push_back(marker);
  }
  return by_entity;
}

std::optional<PoseMinimum> ArucoDetector::solve(const EntityModel& model, const CameraImage& image,
                                                const std::vector<TagCornerObservation>& markers) {
  const auto solution = solveEntityPose(model, image.model, markers, params_.tag_pose);
  if (!solution) {
    ++warnings_[text(solution.error())];
    return std::nullopt;
  }
  // A flat marker has two poses; that the entity stands upright usually tells which.
  OrientationPrior prior;
  prior.up_camera = image.T_base_camera.R.transpose() * Vector3::UnitZ();
  const auto resolved = resolveAmbiguity(*solution, prior, params_.ambiguity);
  if (!resolved) {
    ++warnings_[text(resolved.error())];
    return std::nullopt;
  }
  return resolved->pose;
}

std::vector<EntityObservation> ArucoDetector::detect(const SensorFrame& frame) {
  std::map<std::pair<EntityId, std::string>, EntityObservation> found;
  for (const CameraImage& image : frame.images) {
    // The robot moves between the image and the frame's stamp.
    const auto T_base_image = motionFromFrame(frame, image.stamp, image.odometry);
    if (!T_base_image) ++warnings_["image without odometry: robot motion since the scan ignored"];
    for (const auto& [id, markers] : findMarkers(image)) {
      const EntityModel& model = *models_.findEntity(id);
      const auto pose = solve(model, image, markers);
      if (!pose) continue;
      EntityObservation observation;
      observation.entity = id;
      observation.semantic_class = model.semantic_class;
      observation.name = model.name;
      observation.stamp = image.stamp;
      observation.T_base_entity =
          T_base_image.value_or(Pose3()) * image.T_base_camera * pose->T_camera_entity;
      // Of the right tangent, which is along the entity's own axes: the same in every parent frame.
      observation.covariance = floorCovariance(pose->covariance, params_.min_sigma_translation_m,
                                               params_.min_sigma_rotation_rad);
      observation.reprojection_rms_px = pose->reprojection_rms_px;
      observation.tag_count = static_cast<int>(markers.size());
      observation.sensor_label = image.label;
      found.emplace(std::pair(id, image.label), std::move(observation));
    }
  }
  std::vector<EntityObservation> observations;
  for (auto& [key, observation] : found) observations.push_back(std::move(observation));
  return observations;
}

}  // namespace dynemo
