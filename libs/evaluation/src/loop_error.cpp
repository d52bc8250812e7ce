#include "dynemo/evaluation/loop_error.h"

#include <limits>

namespace dynemo {
namespace {

bool isRight(const PoseError& error, const LoopErrorParams& params) {
  return error.translation_m <= params.max_translation_m &&
         error.rotation_rad <= params.max_rotation_rad;
}

/// Against the true relative pose; empty outside of the reference.
std::optional<PoseError> errorOf(const LoopEstimate& loop, const Trajectory& reference) {
  const auto earlier = poseAt(reference, loop.earlier), later = poseAt(reference, loop.later);
  if (!earlier || !later) return std::nullopt;
  return poseError(earlier->inverse() * *later, loop.T_earlier_later);
}

/// A keyframe at its true pose.
struct TrueKeyframe {
  Stamp stamp;
  Vector3 p_world;
  double path_m = 0.0;
};

std::vector<TrueKeyframe> trueKeyframes(const Trajectory& keyframes, const Trajectory& reference) {
  std::vector<TrueKeyframe> list;
  for (const StampedPose& keyframe : keyframes) {
    const auto truth = poseAt(reference, keyframe.stamp);
    if (!truth) continue;
    const double path_m =
        list.empty() ? 0.0 : list.back().path_m + (truth->t - list.back().p_world).norm();
    list.push_back({keyframe.stamp, truth->t, path_m});
  }
  return list;
}

bool canClose(const std::vector<TrueKeyframe>& keyframes, std::size_t later, const LoopGate& gate,
              const LoopErrorParams& params) {
  for (std::size_t k = 0; k < later; ++k) {
    const Vector3 apart = keyframes[k].p_world - keyframes[later].p_world;
    if (keyframes[later].path_m - keyframes[k].path_m >= gate.min_path_m &&
        apart.head<2>().norm() <= gate.max_distance_m && std::abs(apart.z()) <= params.max_height_m)
      return true;
  }
  return false;
}

void countRecall(const std::vector<Stamp>& right_from, const std::vector<TrueKeyframe>& keyframes,
                 const LoopGate& gate, const LoopErrorParams& params, LoopReport& report) {
  std::optional<double> last_path_m;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const double path_m = keyframes[k].path_m;
    if (last_path_m && path_m - *last_path_m < gate.spacing_m) continue;
    if (!canClose(keyframes, k, gate, params)) continue;
    last_path_m = path_m;
    ++report.closable;
    std::size_t last = k;
    while (last + 1 < keyframes.size() && keyframes[last + 1].path_m - path_m < gate.spacing_m)
      ++last;
    for (const Stamp stamp : right_from) {
      if (stamp < keyframes[k].stamp || keyframes[last].stamp < stamp) continue;
      ++report.recalled;
      break;
    }
  }
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

double LoopReport::precision() const { return share(right, closures); }

double LoopReport::recall() const {
  return gate_known ? share(recalled, closable) : std::numeric_limits<double>::quiet_NaN();
}

LoopReport evaluateLoops(const std::vector<LoopEstimate>& loops, const Trajectory& keyframes,
                         const Trajectory& reference, const std::optional<LoopGate>& gate,
                         const LoopErrorParams& params) {
  LoopReport report;
  std::vector<PoseError> errors;
  std::vector<Stamp> right_from;
  for (const LoopEstimate& loop : loops) {
    const auto error = errorOf(loop, reference);
    if (!error) {
      ++report.without_truth;
      continue;
    }
    const bool right = isRight(*error, params);
    ++(loop.removed ? report.removed : report.closures);
    if (right) ++(loop.removed ? report.removed_right : report.right);
    if (loop.removed) continue;
    errors.push_back(*error);
    if (right) right_from.push_back(loop.later);
  }
  report.errors = summarize(errors);
  report.gate_known = gate.has_value();
  if (gate) countRecall(right_from, trueKeyframes(keyframes, reference), *gate, params, report);
  return report;
}

}  // namespace dynemo
