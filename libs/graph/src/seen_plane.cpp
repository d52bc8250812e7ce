#include "dynemo/graph/seen_plane.h"

#include <algorithm>
#include <cmath>

#include "dynemo/graph/edge_plane.h"

namespace dynemo {

PlanePatch seenPatch(const CSceneGraph& graph, const CNodePlane& plane) {
  PlanePatch seen;
  seen.normal = plane.plane_map.normal;
  // Independent of where it was seen, so that equal planes have equal grids.
  seen.center = -plane.plane_map.d_m * seen.normal;
  const Eigen::Matrix<double, 3, 2> B = orthogonalBasis(seen.normal) / PlanePatch::kCell_m;
  for (const EdgeId id : graph.edgesOf(plane.id)) {
    const auto* edge = dynamic_cast<const CEdgeKeyframePlane*>(graph.edgeSlots()[id.value].get());
    if (!edge) continue;
    const Pose3& T_map_base = graph.getNode<CNodeKeyframe>(edge->nodes[0]).T_map_base();
    const Eigen::Matrix<double, 3, 2> half =
        0.25 * PlanePatch::kCell_m * (T_map_base.R * orthogonalBasis(edge->patch_base.normal));
    for (const Vector3& middle : cellCenters(edge->patch_base, T_map_base)) {
      // Quarters, so that turning one grid into the other leaves no holes.
      for (const Vector2& q : {Vector2(-1, -1), Vector2(-1, 1), Vector2(1, -1), Vector2(1, 1)}) {
        const Vector2 at = B.transpose() * (middle + half * q - seen.center);
        if (at.cwiseAbs().maxCoeff() > 32000.0) continue;
        seen.cells.push_back({static_cast<std::int16_t>(std::floor(at.x())),
                              static_cast<std::int16_t>(std::floor(at.y()))});
      }
    }
  }
  std::sort(seen.cells.begin(), seen.cells.end());
  seen.cells.erase(std::unique(seen.cells.begin(), seen.cells.end()), seen.cells.end());
  return seen;
}

std::optional<NodeId> floorOf(const CSceneGraph& graph, const CNodePlane& plane) {
  std::map<NodeId, int> sightings;
  for (const EdgeId id : graph.edgesOf(plane.id)) {
    const auto* edge = dynamic_cast<const CEdgeKeyframePlane*>(graph.edgeSlots()[id.value].get());
    if (!edge) continue;
    const auto& floor = graph.getNode<CNodeKeyframe>(edge->nodes[0]).floor;
    if (floor) ++sightings[*floor];
  }
  if (sightings.empty()) return std::nullopt;
  return std::max_element(sightings.begin(), sightings.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

Vector3 middleOf(const PlanePatch& patch) {
  if (patch.cells.empty()) return patch.center;
  Vector3 sum = Vector3::Zero();
  for (const Vector3& p : cellCenters(patch)) sum += p;
  return sum / static_cast<double>(patch.cells.size());
}

}  // namespace dynemo
