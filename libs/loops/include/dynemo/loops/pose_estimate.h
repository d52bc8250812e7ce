// Relative poses with their covariances, and how they combine.
#pragma once

#include <optional>
#include <span>

#include "dynemo/core/noise.h"

namespace dynemo {

/// T_a_b with the covariance of its right tangent.
struct PoseEstimate {
  Pose3 T;
  Matrix6 covariance = Matrix6::Zero();
};

/// T_a_c of independent T_a_b and T_b_c.
PoseEstimate compose(const PoseEstimate& a_b, const PoseEstimate& b_c);

/// T_b_a of T_a_b.
PoseEstimate inverse(const PoseEstimate& a_b);

/// Squared Mahalanobis distance of two independent estimates of one pose.
double squaredMahalanobis(const PoseEstimate& a, const PoseEstimate& b);

/// Information-weighted mean of independent estimates of one pose; empty when a covariance is
/// singular or there is none.
std::optional<PoseEstimate> fuse(std::span<const PoseEstimate> estimates);

/// Standard deviation of the translation in its least certain direction.
double largestTranslationSigma(const Matrix6& covariance);

}  // namespace dynemo
