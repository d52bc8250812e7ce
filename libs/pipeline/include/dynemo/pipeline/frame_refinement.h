// Poses of the frames between two keyframes, by odometry and by the objects seen in them.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/core/fields.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/graph/session.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

struct FrameRefinementParams {
  bool objects = true;
  /// On the standard deviations of detections: those of one object in successive frames err alike.
  double detection_scale = 2.0;
  /// Of the robot, from frame to frame; none when empty.
  std::optional<double> acceleration_sigma_m_s2 = 0.5;
  /// Cauchy, in standard deviations.
  double kernel_width = 3.0;
};
void fields(FieldVisitor& v, FrameRefinementParams& p);

/// An object in view, of the right tangent of T_base_entity.
struct ObjectSighting {
  EntityId entity;
  Pose3 T_base_entity;
  Matrix6 covariance;
};

/// What a frame that is no keyframe tells of where it was taken.
struct FrameMeasurements {
  /// Of the right tangent of the motion since the frame before.
  Matrix6 step_covariance = Matrix6::Identity();
  std::vector<ObjectSighting> objects;
};

/// The objects among the observations.
std::vector<ObjectSighting> sightingsOf(const std::vector<EntityObservation>& observations);

/// Moves T_map_base of the frames that keyframe number `keyframe` is the latest of, the first of
/// them being the keyframe itself: the maximum a posteriori of their odometry, held by the
/// keyframes at both ends as the graph has them, of the detections of objects that stood still
/// meanwhile, and of the robot's inertia: a velocity that is kept but for white accelerations.
/// `frames` and `measurements` go on to the next keyframe, where there is one. With neither
/// detections nor inertia nothing moves.
void refineFrames(const CSceneGraph& graph, std::size_t keyframe,
                  const std::map<NodeId, Matrix6>& entity_covariances,
                  std::span<const FrameMeasurements> measurements,
                  const FrameRefinementParams& params, std::span<FramePose> frames);

}  // namespace dynemo
