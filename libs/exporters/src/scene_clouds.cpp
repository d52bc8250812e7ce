#include <mrpt/opengl/CPointCloudColoured.h>

#include "picture_points.h"
#include "scene_style.h"

namespace dynemo {
namespace {

mrpt::opengl::CPointCloudColoured::Ptr draw(const std::vector<PicturePoint>& points, float size_px,
                                            const std::string& name) {
  auto cloud = mrpt::opengl::CPointCloudColoured::Create();
  cloud->setName(name);
  cloud->setPointSize(size_px);
  cloud->reserve(points.size());
  for (const PicturePoint& point : points) {
    const mrpt::img::TColor color = colorFromRgb(point.rgb);
    cloud->insertPoint(
        {point.p_map.x(), point.p_map.y(), point.p_map.z(), color.R, color.G, color.B, color.A});
  }
  return cloud;
}

}  // namespace

mrpt::opengl::CSetOfObjects::Ptr sceneClouds(const RunResult& run, const SceneParams& params) {
  const PicturePoints points = picturePoints(run, params.exports);
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("clouds");
  group->insert(draw(points.structure, params.cloud_point_px, "keyframe clouds"));
  group->insert(draw(points.fragments, params.fragment_point_px, "entity fragments"));
  return group;
}

}  // namespace dynemo
