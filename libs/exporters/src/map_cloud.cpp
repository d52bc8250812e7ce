#include "map_cloud.h"

#include <cmath>
#include <limits>

#include "dynemo/query/scene_query.h"
#include "fragment_owners.h"
#include "voxel_thinning.h"

namespace dynemo {
namespace {

constexpr double kPresent = 0.5;

bool isDrawn(const SceneQuery& query, const Whereabouts& w, Stamp at,
             const MapCloudParams& params) {
  if (w.semantic_class == SemanticClass::kAgent) {
    if (params.entities != EntityPoints::kAll) return false;
    const auto within = [&](const std::optional<Stamp>& seen) {
      return seen && std::abs(secondsBetween(*seen, at)) <= params.agents_within_s;
    };
    return within(w.last_seen) || within(w.next_seen);
  }
  if (params.entities == EntityPoints::kUnmoved && query.stays(w.entity).size() > 1) return false;
  return w.presence >= kPresent;
}

void addEntities(const RunResult& run, const MapCloudParams& params, const QueryParams& query,
                 std::vector<MapPoint>& points) {
  if (params.entities == EntityPoints::kNone) return;
  const SceneQuery scene(run.graph, run.entity_covariances, query);
  const Stamp at = cloudStamp(run, params);
  for (const auto& [id, track] : run.graph.tracks()) {
    const Whereabouts w = scene.where(id, at);
    if (!isDrawn(scene, w, at, params)) continue;
    for (const Vector3& p : fragmentPoints(run.graph, track)) {
      points.push_back({(w.T_map_entity * p).cast<float>(), pointClass(w.semantic_class),
                        static_cast<std::int32_t>(id.value)});
    }
  }
}

void addStructure(const CSceneGraph& graph, const CNodeKeyframe& keyframe,
                  std::vector<MapPoint>& points) {
  const auto owner = fragmentOwners(graph, keyframe);
  const Pose3 T_map_lidar = keyframe.T_map_base() * keyframe.scan->T_base_lidar;
  const auto& cloud = keyframe.scan->cloud.points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!owner[i]) points.push_back({(T_map_lidar * cloud[i].cast<double>()).cast<float>()});
  }
}

}  // namespace

Stamp firstStamp(const RunResult& run) {
  if (!run.frames.empty()) return run.frames.front().stamp;
  return run.graph.keyframes().empty() ? Stamp() : run.graph.keyframes().front()->stamp;
}

Stamp lastStamp(const RunResult& run) {
  if (!run.frames.empty()) return run.frames.back().stamp;
  return run.graph.keyframes().empty() ? Stamp() : run.graph.keyframes().back()->stamp;
}

Stamp cloudStamp(const RunResult& run, const MapCloudParams& params) {
  if (!params.at_s) return lastStamp(run);
  return {firstStamp(run).ns + std::llround(*params.at_s * 1e9)};
}

std::vector<MapPoint> mapCloud(const RunResult& run, const MapCloudParams& params,
                               const QueryParams& query) {
  // Thinning as it goes bounds the memory of long runs.
  constexpr std::size_t kFewToThin = 2'000'000;
  const auto voxel_m = static_cast<float>(params.voxel_m);
  std::vector<MapPoint> points;
  addEntities(run, params, query, points);
  std::size_t thin_at = voxel_m > 0 ? kFewToThin : std::numeric_limits<std::size_t>::max();
  for (const auto& keyframe : run.graph.keyframes()) {
    if (keyframe->scan) addStructure(run.graph, *keyframe, points);
    if (points.size() < thin_at) continue;
    points = thinned(points, voxel_m);
    thin_at = std::max(kFewToThin, 2 * points.size());
  }
  return voxel_m > 0 ? thinned(points, voxel_m) : points;
}

}  // namespace dynemo
