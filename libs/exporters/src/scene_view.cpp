#include "scene_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace dynemo {
namespace {

/// Some points of all keyframes, and the keyframes themselves.
std::vector<Vector3> samplePoints(const CSceneGraph& graph) {
  constexpr std::size_t kStride = 53;
  std::vector<Vector3> points;
  for (const auto& keyframe : graph.keyframes()) {
    points.push_back(keyframe->T_map_base().t);
    if (!keyframe->scan) continue;
    const Pose3 T_map_lidar = keyframe->T_map_base() * keyframe->scan->T_base_lidar;
    const auto& cloud = keyframe->scan->cloud.points;
    for (std::size_t i = 0; i < cloud.size(); i += kStride) {
      points.push_back(T_map_lidar * cloud[i].cast<double>());
    }
  }
  std::erase_if(points, [](const Vector3& p) { return !p.allFinite(); });
  return points;
}

/// The interval that holds most of the values: far returns through a window do not count.
std::pair<double, double> bulk(std::vector<double> values) {
  const auto tail = static_cast<std::ptrdiff_t>(values.size() / 50);
  const auto low = values.begin() + tail, high = values.end() - 1 - tail;
  std::nth_element(values.begin(), low, values.end());
  const double min = *low;
  std::nth_element(values.begin(), high, values.end());
  return {min, *high};
}

/// Most of the points along a direction.
std::pair<double, double> bulkAlong(const std::vector<Vector3>& points, const Vector3& direction) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const Vector3& p : points) values.push_back(direction.dot(p));
  return bulk(std::move(values));
}

/// The smallest rectangle around most of the points, in steps of a few degrees.
SceneView viewAround(const std::vector<Vector3>& points) {
  SceneView view;
  if (points.empty()) return view;
  constexpr int kSteps = 36;
  double smallest_m2 = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kSteps; ++step) {
    const double yaw = std::numbers::pi * step / kSteps;
    const Vector3 along(std::cos(yaw), std::sin(yaw), 0.0), across(-along.y(), along.x(), 0.0);
    const auto [a0, a1] = bulkAlong(points, along);
    const auto [b0, b1] = bulkAlong(points, across);
    if (a1 - a0 < b1 - b0 || (a1 - a0) * (b1 - b0) >= smallest_m2) continue;
    smallest_m2 = (a1 - a0) * (b1 - b0);
    view.yaw_rad = yaw;
    view.half_m = {std::max(0.5, 0.5 * (a1 - a0)), std::max(0.5, 0.5 * (b1 - b0))};
    view.center = 0.5 * (a0 + a1) * along + 0.5 * (b0 + b1) * across;
  }
  const auto [low, high] = bulkAlong(points, Vector3::UnitZ());
  view.center.z() = 0.5 * (low + high);
  view.radius_m = std::max(1.0, std::hypot(view.half_m.norm(), 0.5 * (high - low)));
  return view;
}

}  // namespace

SceneView viewOf(const CSceneGraph& graph) { return viewAround(samplePoints(graph)); }

std::vector<Vector3> uncorrectedWay(const RunResult& run) {
  std::vector<Vector3> points;
  if (run.graph.keyframes().empty()) return points;
  const CNodeKeyframe& first = *run.graph.keyframes().front();
  const Pose3 T_map_odom = first.T_map_base() * first.T_odom_base.inverse();
  for (const FramePose& frame : run.frames) points.push_back(T_map_odom * frame.T_odom_base.t);
  return points;
}

}  // namespace dynemo
