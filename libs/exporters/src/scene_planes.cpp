#include <mrpt/opengl/CSetOfTriangles.h>

#include "dynemo/graph/seen_plane.h"
#include "scene_style.h"

namespace dynemo {
namespace {

/// Ceilings would hide the rooms from the eye above.
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

void addRectangle(mrpt::opengl::CSetOfTriangles& mesh, const PlanePatch& patch, const Strip& strip,
                  const mrpt::img::TColor& color) {
  const Eigen::Matrix<double, 3, 2> axes = PlanePatch::kCell_m * orthogonalBasis(patch.normal);
  const auto corner = [&](double a, double b) {
    return toPoint(patch.center + axes * Vector2(a, b)).cast<float>();
  };
  const auto p00 = corner(strip.from.x(), strip.from.y()),
             p01 = corner(strip.from.x(), strip.to.y());
  const auto p10 = corner(strip.to.x(), strip.from.y()), p11 = corner(strip.to.x(), strip.to.y());
  for (mrpt::opengl::TTriangle triangle :
       {mrpt::opengl::TTriangle(p00, p10, p01), mrpt::opengl::TTriangle(p01, p10, p11)}) {
    triangle.setColor(color);
    mesh.insertTriangle(triangle);
  }
}

}  // namespace

mrpt::opengl::CSetOfObjects::Ptr scenePlanes(const RunResult& run, const SceneParams& params) {
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("planes");
  const auto color = colorFromRgb(params.plane_rgb, params.plane_alpha);
  for (const auto& plane : run.graph.planes()) {
    if (!plane->plane_map.isFinite() || plane->plane_map.normal.z() < kCeiling) continue;
    const PlanePatch patch = seenPatch(run.graph, *plane);
    auto mesh = mrpt::opengl::CSetOfTriangles::Create();
    mesh->setName("plane " + std::to_string(plane->id.value));
    mesh->setColor_u8(color);
    for (const Strip& strip : strips(patch)) addRectangle(*mesh, patch, strip, color);
    group->insert(mesh);
  }
  return group;
}

}  // namespace dynemo
