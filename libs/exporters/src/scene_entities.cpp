#include <mrpt/opengl/CArrow.h>
#include <mrpt/opengl/CBox.h>
#include <mrpt/opengl/CSphere.h>
#include <mrpt/opengl/stock_objects.h>

#include <algorithm>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/query/entity_extent.h"
#include "scene_style.h"

namespace dynemo {
namespace {

using mrpt::opengl::CSetOfObjects;

mrpt::opengl::CBox::Ptr box(const Pose3& T_map_entity, const Extent& extent,
                            const mrpt::img::TColor& color, bool wireframe) {
  auto object =
      mrpt::opengl::CBox::Create(toPoint(extent.min), toPoint(extent.max), wireframe, 2.0f);
  object->setColor_u8(color);
  object->setBoxBorderColor({color.R, color.G, color.B, 255});
  object->setPose(toMrpt(T_map_entity));
  return object;
}

double topOf(const Pose3& T_map_entity, const Extent& extent) {
  double top = T_map_entity.t.z();
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 p((corner & 1) ? extent.max.x() : extent.min.x(),
                    (corner & 2) ? extent.max.y() : extent.min.y(),
                    (corner & 4) ? extent.max.z() : extent.min.z());
    top = std::max(top, (T_map_entity * p).z());
  }
  return top;
}

void drawLatest(CSetOfObjects& group, const CNodeEntity& node, const Extent& extent,
                const SceneParams& params) {
  const Pose3& T_map_entity = node.T_map_entity();
  group.insert(box(T_map_entity, extent, entityColor(node.entity, 110), false));
  auto axes = mrpt::opengl::stock_objects::CornerXYZSimple(0.25f, 2.0f);
  axes->setPose(toMrpt(T_map_entity));
  group.insert(axes);
  if (!params.labels) return;
  constexpr double kGap_m = 0.1;
  const Vector3 above(T_map_entity.t.x(), T_map_entity.t.y(), topOf(T_map_entity, extent) + kGap_m);
  group.insert(label(entityTitle(node), above, colorFromRgb(0x101010), params));
}

void drawTrack(CSetOfObjects& group, const EntityTrack& track, const SceneParams& params) {
  const mrpt::img::TColor color = entityColor(track.front()->entity);
  std::vector<Vector3> points;
  for (const auto& node : track) {
    points.push_back(node->T_map_entity().t);
    auto dot = mrpt::opengl::CSphere::Create(static_cast<float>(2.0 * params.track_radius_m), 8);
    dot->setColor_u8(color);
    dot->setLocation(toPoint(points.back()));
    group.insert(dot);
  }
  group.insert(tube(points, params.track_radius_m, params.shortest_step_m, color));
}

/// The object's ghost where it was and an arrow to where it was seen next.
void drawDisplacement(CSetOfObjects& group, const CNodeEntity& before, const CNodeEntity& after,
                      const Extent& extent) {
  group.insert(box(before.T_map_entity(), extent, entityColor(before.entity, 255), true));
  group.insert(box(before.T_map_entity(), extent, entityColor(before.entity, 40), false));
  constexpr double kShortest_m = 0.05;
  // From top to top, so that the boxes do not hide the ends.
  Vector3 from = before.T_map_entity().t, to = after.T_map_entity().t;
  from.z() = topOf(before.T_map_entity(), extent);
  to.z() = topOf(after.T_map_entity(), extent);
  const double length_m = (to - from).norm();
  if (length_m < kShortest_m) return;
  // MRPT's head ratio is a share of the length; keep the head one size.
  const auto head = static_cast<float>(std::min(0.4, 0.25 / length_m));
  auto arrow = mrpt::opengl::CArrow::Create(toPoint(from).cast<float>(), toPoint(to).cast<float>(),
                                            head, 0.025f, 0.08f);
  arrow->setColor_u8(entityColor(before.entity));
  group.insert(arrow);
}

void drawEntity(CSetOfObjects& group, const CSceneGraph& graph, const EntityTrack& track,
                const SceneParams& params) {
  const Extent extent = extentOf(fragmentPoints(graph, track)).value_or(Extent());
  drawLatest(group, *track.back(), extent, params);
  if (track.back()->semantic_class == SemanticClass::kAgent) {
    drawTrack(group, track, params);
    return;
  }
  for (std::size_t i = 1; i < track.size(); ++i) {
    if (track[i]->moved) drawDisplacement(group, *track[i - 1], *track[i], extent);
  }
}

}  // namespace

CSetOfObjects::Ptr sceneEntities(const RunResult& run, const SceneParams& params) {
  auto all = CSetOfObjects::Create();
  all->setName("entities");
  for (const auto& [id, track] : run.graph.tracks()) {
    if (track.empty()) continue;
    auto group = CSetOfObjects::Create();
    group->setName(entityTitle(*track.back()));
    drawEntity(*group, run.graph, track, params);
    all->insert(group);
  }
  return all;
}

}  // namespace dynemo
