#include <mrpt/opengl/CGridPlaneXY.h>
#include <mrpt/opengl/CSetOfLines.h>

#include "edge_lines.h"
#include "scene_style.h"

namespace dynemo {

mrpt::opengl::CSetOfObjects::Ptr sceneEdges(const RunResult& run, const SceneParams& params) {
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("edges");
  for (const EdgeKindLines& kind : edgeLines(run.graph)) {
    auto lines = mrpt::opengl::CSetOfLines::Create();
    lines->setName(kind.kind);
    lines->setLineWidth(params.edge_line_px);
    lines->setColor_u8(colorFromRgb(kind.color_rgb, 160));
    for (const EdgeLines& edge : kind.edges) {
      for (const EdgeLine& line : edge.lines) {
        lines->appendLine(toPoint(line.from), toPoint(line.to));
      }
    }
    group->insert(lines);
  }
  return group;
}

mrpt::opengl::CSetOfObjects::Ptr sceneFloors(const RunResult& run, const SceneParams&) {
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("floors");
  for (const auto& floor : run.graph.floors()) {
    const auto area = floorArea(run.graph, *floor);
    if (!area) continue;
    const Eigen::Vector2f min = area->min().cast<float>(), max = area->max().cast<float>();
    auto grid = mrpt::opengl::CGridPlaneXY::Create(min.x(), max.x(), min.y(), max.y(),
                                                   static_cast<float>(floor->level_m), 1.0f);
    grid->setColor_u8(colorFromRgb(0xb8b8b8));
    grid->setName("floor " + std::to_string(floor->id.value));
    group->insert(grid);
  }
  return group;
}

}  // namespace dynemo
