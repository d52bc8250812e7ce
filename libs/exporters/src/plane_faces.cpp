#include "plane_faces.h"

#include "dynemo/graph/seen_plane.h"

namespace dynemo {
namespace {

constexpr double kCeiling = -0.7;

struct Strip {
  Vector2 from, to;  ///< opposite corners, in cells
};

/// Cells that follow each other along the second axis as one rectangle.
std::vector<Strip> strips(const PlanePatch& patch) {
  std::vector<Strip> list;
  for (std::size_t i = 0; i < patch.cells.size(); ++i) {
    const auto& [a, b] = patch.cells[i];
    const bool continues = i > 0 && patch.cells[i - 1][0] == a && patch.cells[i - 1][1] + 1 == b;
    if (!continues) list.push_back({Vector2(a, b), Vector2(a + 1, b + 1)});
    list.back().to.y() = b + 1;
  }
  return list;
}

void addRectangle(const PlanePatch& patch, const Strip& strip, std::vector<Vector3>& triangles) {
  const Eigen::Matrix<double, 3, 2> axes = PlanePatch::kCell_m * orthogonalBasis(patch.normal);
  const auto corner = [&](double a, double b) -> Vector3 {
    return patch.center + axes * Vector2(a, b);
  };
  const Vector3 p00 = corner(strip.from.x(), strip.from.y()),
                p01 = corner(strip.from.x(), strip.to.y()),
                p10 = corner(strip.to.x(), strip.from.y()),
                p11 = corner(strip.to.x(), strip.to.y());
  triangles.insert(triangles.end(), {p00, p10, p01, p01, p10, p11});
}

}  // namespace

std::vector<PlaneFace> planeFaces(const CSceneGraph& graph) {
  std::vector<PlaneFace> faces;
  for (const auto& plane : graph.planes()) {
    if (!plane->plane_map.isFinite()) continue;
    const PlanePatch patch = seenPatch(graph, *plane);
    PlaneFace face{
        plane.get(), patch.area_m2(), middleOf(patch), {}, plane->plane_map.normal.z() < kCeiling};
    for (const Strip& strip : strips(patch)) addRectangle(patch, strip, face.triangles);
    faces.push_back(std::move(face));
  }
  return faces;
}

}  // namespace dynemo
