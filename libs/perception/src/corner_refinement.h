// Levenberg–Marquardt on the reprojection error of an entity's tag corners.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/perception/tag_pose.h"

namespace dynemo {

/// A tag of the entity with what the solver needs of it.
struct TagMeasurement {
  int tag_id = 0;
  std::array<Vector3, 4> corners_entity;
  TagCornerObservation observation;
  const TagModel* model = nullptr;
  double sigma_px = 1.0;
};

enum class CornerLoss { kSquared, kCauchy };

/// The minimum next to T_camera_entity; empty when it cannot be evaluated there.
std::optional<PoseMinimum> refine(const Pose3& T_camera_entity, const CameraModel& camera,
                                  std::span<const TagMeasurement> tags, CornerLoss loss,
                                  int max_iterations);

/// RMS corner distance of one tag [px]; empty when a corner does not project.
std::optional<double> reprojectionRms_px(const Pose3& T_camera_entity, const CameraModel& camera,
                                         const TagMeasurement& tag);

}  // namespace dynemo
