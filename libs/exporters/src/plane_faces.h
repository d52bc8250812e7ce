// Planes as far as they were seen, for every format that draws them.
#pragma once

#include <string>
#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

struct PlaneFace {
  const CNodePlane* plane = nullptr;
  double area_m2 = 0.0;
  Vector3 middle = Vector3::Zero();
  /// Corners of triangles, three by three, in the map frame.
  std::vector<Vector3> triangles;
  /// It looks down: it would hide the rooms from an eye above.
  bool is_ceiling = false;

  std::string title() const { return "plane " + std::to_string(plane->id.value); }
};

/// By node id; planes without a finite estimate are left out.
std::vector<PlaneFace> planeFaces(const CSceneGraph& graph);

constexpr std::uint32_t kPlaneRgb = 0x9aa7b5;

}  // namespace dynemo
