#include <mrpt/opengl/CSetOfTriangles.h>

#include "plane_faces.h"
#include "scene_style.h"

namespace dynemo {

mrpt::opengl::CSetOfObjects::Ptr scenePlanes(const RunResult& run, const SceneParams& params) {
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("planes");
  const auto color = colorFromRgb(kPlaneRgb, params.plane_alpha);
  for (const PlaneFace& face : planeFaces(run.graph)) {
    if (face.is_ceiling) continue;
    auto mesh = mrpt::opengl::CSetOfTriangles::Create();
    mesh->setName(face.title());
    mesh->setColor_u8(color);
    for (std::size_t i = 0; i + 2 < face.triangles.size(); i += 3) {
      mrpt::opengl::TTriangle triangle(toPoint(face.triangles[i]).cast<float>(),
                                       toPoint(face.triangles[i + 1]).cast<float>(),
                                       toPoint(face.triangles[i + 2]).cast<float>());
      triangle.setColor(color);
      mesh->insertTriangle(triangle);
    }
    group->insert(mesh);
  }
  return group;
}

}  // namespace dynemo
