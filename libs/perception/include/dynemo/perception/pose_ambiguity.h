// Which of the two poses that a planar tag allows is the true one.
#pragma once

#include <optional>

#include "dynemo/perception/tag_pose.h"

namespace dynemo {

/// What is known of the entity's orientation besides the image; the camera frame is the one of the
/// solution.
struct OrientationPrior {
  /// Unit vector away from the ground, when the entity stands on it upright (its z axis up).
  std::optional<Vector3> up_camera;
  /// From its last unambiguous observation.
  std::optional<Matrix3> R_camera_entity;
};

struct AmbiguityParams {
  enum class Fallback { kReject, kInflate };
  /// Difference of squared whitened errors between the two minima from which the better one is
  /// trusted.
  double min_evidence = 9.0;
  bool entities_are_upright = true;
  double upright_sigma_rad = 0.05;
  double prediction_sigma_rad = 0.35;
  double prediction_max_age_s = 1.0;
  /// When nothing decides: give the pose up, or widen its covariance over both minima.
  Fallback fallback = Fallback::kReject;
};
void fields(FieldVisitor& v, AmbiguityParams& p);

struct ResolvedPose {
  PoseMinimum pose;
  /// Whether the image and the upright prior suffice; only such poses may predict later ones.
  bool decided_without_prediction = true;
};

/// The likelier minimum given the prior, or kAmbiguous.
Expected<ResolvedPose, TagPoseFailure> resolveAmbiguity(const EntityPoseSolution& solution,
                                                        const OrientationPrior& prior,
                                                        const AmbiguityParams& params);

}  // namespace dynemo
