// The pose of an entity from the corners of its visible tags.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "dynemo/core/error.h"
#include "dynemo/core/fields.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/perception/entity_model.h"

namespace dynemo {

/// One tag found in one image.
struct TagCornerObservation {
  int tag_id = 0;
  /// Integer coordinates are pixel centres; in the order of TagModel::corners().
  std::array<Vector2, 4> corners_px;
};

/// Length in pixels of the shortest way across the quadrilateral: edge · cos tilt of a square tag.
double effectiveEdge_px(const TagCornerObservation& tag);

struct TagPoseParams {
  // σ_px = max(floor, base + slope / effective edge)
  double corner_sigma_base_px = 0.07;
  double corner_sigma_slope_px2 = 1.0;
  double corner_sigma_floor_px = 0.05;
  double min_edge_px = 10.0;
  double max_reprojection_px = 2.0;
  int max_iterations = 30;
};
void fields(FieldVisitor& v, TagPoseParams& p);

enum class TagPoseFailure {
  kNoUsableTag,   ///< none of the entity's tags, or too small, or outside of what the lens model
                  ///< covers
  kNotConverged,  ///< no start led to a finite minimum
  kReprojection,  ///< the best pose misses the corners by more than allowed
  kInconsistentTags,  ///< the tags contradict the entity's model, or each other, without a majority
  kAmbiguous,         ///< two poses explain the image and nothing tells them apart
};
const char* text(TagPoseFailure failure);

/// One minimum of the reprojection error.
struct PoseMinimum {
  Pose3 T_camera_entity;
  /// σ²(JᵀJ)⁻¹ of the right tangent of T_camera_entity; larger when the residuals are larger than
  /// the noise model says.
  Matrix6 covariance = Matrix6::Identity();
  double chi2 = 0.0;  ///< squared whitened reprojection error
  double reprojection_rms_px = 0.0;
};

struct EntityPoseSolution {
  PoseMinimum best;
  /// A planar target has a second minimum, close to the first in error when it is small or seen
  /// frontally.
  std::optional<PoseMinimum> second;
  std::vector<int> used_tags;      ///< ascending
  std::vector<int> rejected_tags;  ///< disagree with the majority, ascending
  int degrees_of_freedom = 0;
};

/// Least squares over the corners of all of the entity's tags, from both solutions of IPPE (Collins
/// & Bartoli, 2014) of the largest tags. Tags of other entities and repeated tags are ignored.
Expected<EntityPoseSolution, TagPoseFailure> solveEntityPose(
    const EntityModel& model, const CameraModel& camera, std::span<const TagCornerObservation> tags,
    const TagPoseParams& params);

}  // namespace dynemo
