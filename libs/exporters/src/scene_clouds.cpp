#include <mrpt/opengl/CPointCloudColoured.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "scene_style.h"

namespace dynemo {
namespace {

using mrpt::img::TColor;

struct ColoredPoint {
  Eigen::Vector3f p_map;
  TColor color;
};

/// Membership only; nothing is read out in its order.
struct VoxelHash {
  std::size_t operator()(const Eigen::Vector3i& v) const {
    return static_cast<std::size_t>(v.x()) * 73856093u ^
           static_cast<std::size_t>(v.y()) * 19349669u ^
           static_cast<std::size_t>(v.z()) * 83492791u;
  }
};

/// The first point of each voxel.
std::vector<ColoredPoint> thinned(const std::vector<ColoredPoint>& points, float voxel_m) {
  std::unordered_set<Eigen::Vector3i, VoxelHash> seen;
  std::vector<ColoredPoint> kept;
  // Beyond this a float cannot be told from its neighbour voxel anyway, and the index would
  // overflow.
  constexpr float kFarthest = 1e6f;
  for (const ColoredPoint& point : points) {
    const Eigen::Vector3f scaled = point.p_map / voxel_m;
    if (!(scaled.cwiseAbs().maxCoeff() < kFarthest)) continue;
    const Eigen::Vector3i voxel = scaled.array().floor().cast<int>();
    if (seen.insert(voxel).second) kept.push_back(point);
  }
  return kept;
}

std::vector<ColoredPoint> withinBudget(std::vector<ColoredPoint> points,
                                       const SceneParams& params) {
  auto voxel_m = static_cast<float>(params.voxel_m);
  points = thinned(points, voxel_m);
  while (points.size() > params.max_points) {
    voxel_m *= 1.5f;
    points = thinned(points, voxel_m);
  }
  return points;
}

/// Bluish grey, lighter with height, so that entities stand out.
TColor structureColor(double height_m, double cutaway_m) {
  const double share = std::clamp(height_m / cutaway_m, 0.0, 1.0);
  const auto mix = [share](double low, double high) {
    return static_cast<std::uint8_t>(std::lround(low + share * (high - low)));
  };
  return {mix(120, 190), mix(135, 205), mix(160, 225), 255};
}

/// Entity of each point of a keyframe's scan; empty where it belongs to none.
std::vector<const CNodeEntity*> fragmentOwners(const CSceneGraph& graph,
                                               const CNodeKeyframe& keyframe) {
  std::vector<const CNodeEntity*> owner(keyframe.scan->cloud.size(), nullptr);
  for (const EdgeId id : graph.edgesOf(keyframe.id)) {
    for (const NodeId node : graph.edgeSlots()[id.value]->nodes) {
      const auto* entity = graph.findNode<CNodeEntity>(node);
      if (!entity || entity->keyframe != keyframe.id) continue;
      for (const std::uint32_t i : entity->fragment) {
        if (i < owner.size()) owner[i] = entity;
      }
    }
  }
  return owner;
}

struct Clouds {
  std::vector<ColoredPoint> structure, fragments;
};

void addKeyframe(const CSceneGraph& graph, const CNodeKeyframe& keyframe, const SceneParams& params,
                 Clouds& clouds) {
  if (!keyframe.scan) return;
  const auto owner = fragmentOwners(graph, keyframe);
  const Pose3& T_base_lidar = keyframe.scan->T_base_lidar;
  const auto& points = keyframe.scan->cloud.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 p_base = T_base_lidar * points[i].cast<double>();
    const Eigen::Vector3f p_map = (keyframe.T_map_base() * p_base).cast<float>();
    if (owner[i]) {
      clouds.fragments.push_back({p_map, entityColor(owner[i]->entity)});
    } else if (p_base.z() <= params.cutaway_height_m) {
      clouds.structure.push_back({p_map, structureColor(p_base.z(), params.cutaway_height_m)});
    }
  }
}

mrpt::opengl::CPointCloudColoured::Ptr draw(const std::vector<ColoredPoint>& points, float size_px,
                                            const std::string& name) {
  auto cloud = mrpt::opengl::CPointCloudColoured::Create();
  cloud->setName(name);
  cloud->setPointSize(size_px);
  cloud->reserve(points.size());
  for (const ColoredPoint& point : points) {
    cloud->insertPoint({point.p_map.x(), point.p_map.y(), point.p_map.z(), point.color.R,
                        point.color.G, point.color.B, point.color.A});
  }
  return cloud;
}

}  // namespace

mrpt::opengl::CSetOfObjects::Ptr sceneClouds(const RunResult& run, const SceneParams& params) {
  Clouds clouds;
  for (const auto& keyframe : run.graph.keyframes()) {
    addKeyframe(run.graph, *keyframe, params, clouds);
    // Thinning as it goes bounds the memory of long runs.
    if (clouds.structure.size() > 4 * params.max_points) {
      clouds.structure = withinBudget(std::move(clouds.structure), params);
    }
  }
  auto group = mrpt::opengl::CSetOfObjects::Create();
  group->setName("clouds");
  group->insert(draw(withinBudget(std::move(clouds.structure), params), params.cloud_point_px,
                     "keyframe clouds"));
  group->insert(draw(withinBudget(std::move(clouds.fragments), params), params.fragment_point_px,
                     "entity fragments"));
  return group;
}

}  // namespace dynemo
