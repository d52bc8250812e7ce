#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/stock_objects.h>

#include "dynemo/core/mrpt_conversions.h"
#include "scene_style.h"
#include "scene_view.h"

namespace dynemo {
namespace {

mrpt::opengl::CSetOfLines::Ptr polyline(const std::vector<Vector3>& points,
                                        const mrpt::img::TColor& color, const std::string& name) {
  auto lines = mrpt::opengl::CSetOfLines::Create();
  lines->setName(name);
  lines->setColor_u8(color);
  for (std::size_t i = 1; i < points.size(); ++i) {
    lines->appendLine(toPoint(points[i - 1]), toPoint(points[i]));
  }
  return lines;
}

}  // namespace

mrpt::opengl::CSetOfObjects::Ptr sceneTrajectory(const RunResult& run, const SceneParams& params) {
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("trajectory");
  std::vector<Vector3> optimised;
  for (const FramePose& frame : run.frames) optimised.push_back(frame.T_map_base.t);
  auto path = tube(optimised, params.trajectory_radius_m, params.shortest_step_m,
                   colorFromRgb(kTrajectoryRgb));
  path->setName("optimised");
  group->insert(path);
  group->insert(polyline(uncorrectedWay(run), colorFromRgb(kOdometryRgb), "odometry"));
  for (const auto& keyframe : run.graph.keyframes()) {
    auto axes = mrpt::opengl::stock_objects::CornerXYZSimple(0.12f, 2.0f);
    axes->setPose(toMrpt(keyframe->T_map_base()));
    axes->setName("keyframe " + std::to_string(keyframe->id.value));
    group->insert(axes);
  }
  return group;
}

}  // namespace dynemo
