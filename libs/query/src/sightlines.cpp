#include "dynemo/query/sightlines.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dynemo {
namespace {

/// Where the line from a to b is inside the box, as shares of its length; empty when it misses it.
std::optional<std::pair<double, double>> insideBox(const Vector3& a, const Vector3& b,
                                                   const Vector3& min, const Vector3& max) {
  double in = 0.0, out = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double d = b[axis] - a[axis];
    if (std::abs(d) < 1e-12) {
      if (a[axis] < min[axis] || a[axis] > max[axis]) return std::nullopt;
      continue;
    }
    const double s0 = (min[axis] - a[axis]) / d, s1 = (max[axis] - a[axis]) / d;
    in = std::max(in, std::min(s0, s1));
    out = std::min(out, std::max(s0, s1));
  }
  if (in > out) return std::nullopt;
  return std::pair(in, out);
}

}  // namespace

RayCount countRays(const PointCloud& cloud, const Pose3& T_entity_lidar, const Extent& extent) {
  constexpr double kShrunk = 0.7;
  constexpr double kMargin_m = 0.1;
  const Vector3 center = 0.5 * (extent.min + extent.max);
  const Vector3 half = 0.5 * kShrunk * (extent.max - extent.min);
  RayCount rays;
  for (const auto& point : cloud.points) {
    const Vector3 end = T_entity_lidar * point.cast<double>();
    const auto inside = insideBox(T_entity_lidar.t, end, center - half, center + half);
    if (!inside) continue;
    const double margin = kMargin_m / (end - T_entity_lidar.t).norm();
    if (inside->second + margin < 1.0) {
      ++rays.through;
    } else if (inside->first - margin < 1.0) {
      ++rays.hits;
    }
  }
  return rays;
}

std::optional<double> likelihoodRatio(const RayCount& rays, const QueryParams& params) {
  constexpr double kClear = 0.8;
  const int all = rays.hits + rays.through;
  if (all < params.min_rays) return std::nullopt;
  if (rays.through >= kClear * all) {
    return params.missed_probability / (1.0 - params.false_probability);
  }
  if (rays.hits >= kClear * all) {
    return (1.0 - params.missed_probability) / params.false_probability;
  }
  return std::nullopt;
}

std::vector<Look> looksAt(const CSceneGraph& graph, const Pose3& T_map_entity, const Extent& extent,
                          Stamp from, Stamp to, const QueryParams& params) {
  std::vector<Look> looks;
  for (const auto& keyframe : graph.keyframes()) {
    if (!keyframe->scan || keyframe->stamp <= from || keyframe->stamp >= to) continue;
    const Pose3 T_entity_lidar =
        T_map_entity.inverse() * keyframe->T_map_base() * keyframe->scan->T_base_lidar;
    if (T_entity_lidar.t.norm() > params.max_range_m) continue;
    const auto ratio =
        likelihoodRatio(countRays(keyframe->scan->cloud, T_entity_lidar, extent), params);
    if (ratio) looks.push_back({secondsBetween(from, keyframe->stamp), *ratio});
  }
  return looks;
}

double missedProbability(const CSceneGraph& graph, const std::vector<Stay>& stays,
                         const Extent& extent, const QueryParams& params) {
  double empty = params.missed_probability * params.missed_prior_looks;
  double all = params.missed_prior_looks;
  for (const Stay& stay : stays) {
    const Stamp from{stay.first_seen.ns - 1}, to{stay.last_seen.ns + 1};
    for (const Look& look : looksAt(graph, stay.T_map_entity, extent, from, to, params)) {
      empty += look.likelihood_ratio < 1.0 ? 1.0 : 0.0;
      all += 1.0;
    }
  }
  // A place that looks empty is never a sign that something stands there.
  return std::min(empty / all, 1.0 - params.false_probability);
}

}  // namespace dynemo
