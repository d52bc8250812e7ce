#include "dynemo/query/entity_extent.h"

#include <algorithm>

namespace dynemo {

std::vector<Vector3> fragmentPoints(const CSceneGraph& graph, const EntityTrack& track) {
  std::vector<Vector3> points;
  for (const auto& node : track) {
    const auto* keyframe = graph.findNode<CNodeKeyframe>(node->keyframe);
    if (!keyframe || !keyframe->scan) continue;
    const Pose3 T_entity_lidar =
        node->T_map_entity().inverse() * keyframe->T_map_base() * keyframe->scan->T_base_lidar;
    for (const std::uint32_t i : node->fragment) {
      if (i >= keyframe->scan->cloud.size()) continue;
      points.push_back(T_entity_lidar * keyframe->scan->cloud.points[i].cast<double>());
    }
  }
  return points;
}

std::optional<Extent> extentOf(std::vector<Vector3> points) {
  constexpr std::size_t kFewest = 20;
  if (points.size() < kFewest) return std::nullopt;
  // Outliers of the clustering would blow the box up.
  const std::size_t tail = points.size() / 50;
  Extent extent;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(points.begin(), points.end(),
              [axis](const Vector3& a, const Vector3& b) { return a[axis] < b[axis]; });
    extent.min[axis] = points[tail][axis];
    extent.max[axis] = points[points.size() - 1 - tail][axis];
  }
  return extent;
}

std::string entityTitle(const CNodeEntity& node) {
  const std::string id = std::to_string(node.entity.value);
  const std::string name = node.name.empty() ? semanticClassName(node.semantic_class) : node.name;
  return name.find(id) == std::string::npos ? name + " " + id : name;
}

}  // namespace dynemo
