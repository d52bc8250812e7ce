// Cameras, entities and images of tags with exactly known geometry.
#pragma once

#include <opencv2/core/mat.hpp>
#include <random>
#include <string>
#include <vector>

#include "dynemo/perception/entity_model.h"
#include "dynemo/perception/tag_pose.h"

namespace dynemo::test {

/// 640×480, by distortion model, with strong coefficients.
CameraModel testCamera(DistortionModel distortion);

/// A tag on an upright face: `outward` is the face's normal in the entity frame (horizontal).
TagModel faceTag(int tag_id, double size_m, const Vector3& centre, const Vector3& outward);

/// A box with tags 0–3 on its front, back, left and right faces.
EntityModel boxEntity(EntityId id, double half_side_m = 0.25, double tag_size_m = 0.28);

/// T_base_camera of a camera that looks along the base's x axis.
Pose3 forwardCamera();

/// T_camera_entity of an upright entity `distance_m` ahead, turned by yaw about its z axis; at yaw
/// 0 the camera sees its back, at π its front.
Pose3 uprightAhead(double distance_m, double yaw_rad, double left_m = 0.0, double down_m = 0.2);

/// The corners of those tags that face the camera, with Gaussian noise.
std::vector<TagCornerObservation> visibleCorners(const EntityModel& model,
                                                 const CameraModel& camera,
                                                 const Pose3& T_camera_entity, double sigma_px,
                                                 std::mt19937& generator);

/// Draws the entity's visible tags into the image as the camera would see them.
void drawTags(const EntityModel& model, const std::string& family, const CameraModel& camera,
              const Pose3& T_camera_entity, cv::Mat& image);

/// A grey background with the camera's size.
cv::Mat blankImage(const CameraModel& camera);

}  // namespace dynemo::test
