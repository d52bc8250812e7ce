#include "dynemo/evaluation/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dynemo {
namespace {

using IndexPair = std::pair<std::size_t, std::size_t>;

std::vector<Vector3> positions(const Trajectory& trajectory) {
  std::vector<Vector3> list;
  for (const StampedPose& pose : trajectory) list.push_back(pose.T.t);
  return list;
}

std::vector<double> pathLengths(const Trajectory& trajectory) {
  std::vector<double> length(trajectory.size(), 0.0);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length[i] = length[i - 1] + (trajectory[i].T.t - trajectory[i - 1].T.t).norm();
  }
  return length;
}

std::vector<IndexPair> pairsByPath(const Trajectory& trajectory, double delta, double tolerance) {
  const std::vector<double> length = pathLengths(trajectory);
  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i + 1 < length.size(); ++i) {
    const double target = length[i] + delta;
    const auto first = length.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    // Lengths never decrease, so the nearest is the first one not below the target or the one
    // before.
    auto best = std::lower_bound(first, length.end(), target);
    if (best == length.end() || (best != first && target - *(best - 1) <= *best - target)) --best;
    // A standing robot repeats lengths: the earliest of equals.
    best = std::lower_bound(first, length.end(), *best);
    if (std::abs(*best - target) > tolerance) continue;
    pairs.emplace_back(i, static_cast<std::size_t>(best - length.begin()));
  }
  return pairs;
}

std::vector<IndexPair> pairsByFrames(std::size_t count, std::size_t delta) {
  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i + delta < count; ++i) pairs.emplace_back(i, i + delta);
  return pairs;
}

}  // namespace

Expected<AlignedTrajectories, AlignmentFailure> alignTrajectories(const Trajectory& reference,
                                                                  const Trajectory& estimate,
                                                                  const AssociationParams& params) {
  AlignedTrajectories aligned;
  for (const auto& [i, j] : associate(reference, estimate, params.max_difference_s)) {
    aligned.reference.push_back(reference[i]);
    aligned.estimate.push_back(estimate[j]);
  }
  const auto T = alignPoints(positions(aligned.reference), positions(aligned.estimate));
  if (!T) return make_unexpected(T.error());
  aligned.T_reference_estimate = *T;
  aligned.estimate = transformed(aligned.estimate, *T);
  return aligned;
}

Statistics absoluteTranslationError(const AlignedTrajectories& aligned) {
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < aligned.reference.size(); ++i) {
    errors_m.push_back((aligned.reference[i].T.t - aligned.estimate[i].T.t).norm());
  }
  return summarize(errors_m);
}

RelativePoseErrors relativePoseErrors(const AlignedTrajectories& aligned,
                                      const RelativePoseParams& params) {
  const auto& [reference, estimate, T] = aligned;
  const auto pairs = params.unit == RelativePoseParams::Unit::kMeters
                         ? pairsByPath(estimate, params.delta, params.delta * params.tolerance)
                         : pairsByFrames(estimate.size(), static_cast<std::size_t>(params.delta));
  std::vector<double> translations_m, rotations_rad;
  for (const auto& [i, j] : pairs) {
    const Pose3 true_motion = reference[i].T.inverse() * reference[j].T;
    const Pose3 error = true_motion.inverse() * (estimate[i].T.inverse() * estimate[j].T);
    translations_m.push_back(error.t.norm());
    rotations_rad.push_back(rotationAngle(error));
  }
  return {summarize(translations_m), summarize(rotations_rad)};
}

}  // namespace dynemo
