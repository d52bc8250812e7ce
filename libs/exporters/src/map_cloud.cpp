#include "map_cloud.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "dynemo/query/point_owners.h"
#include "dynemo/query/scene_query.h"
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

/// The entities that the cloud holds, where they stand in it.
std::map<EntityId, Pose3> drawnEntities(const RunResult& run, const ExportParams& params) {
  std::map<EntityId, Pose3> drawn;
  if (params.cloud.entities == EntityPoints::kNone) return drawn;
  const SceneQuery scene(run.graph, run.entity_covariances, params.query);
  const Stamp at = cloudStamp(run, params.cloud);
  for (const auto& [id, track] : run.graph.tracks()) {
    const Whereabouts w = scene.where(id, at);
    if (isDrawn(scene, w, at, params.cloud)) drawn.emplace(id, w.T_map_entity);
  }
  return drawn;
}

/// Points that are thinned as they come: this bounds the memory of long runs.
class ThinnedPoints {
 public:
  explicit ThinnedPoints(double voxel_m) : voxel_m_(static_cast<float>(voxel_m)) {}
  void add(const MapPoint& point) { points_.push_back(point); }
  void thinWhenMany() {
    if (voxel_m_ > 0 && points_.size() >= thin_at_) {
      points_ = thinned(points_, voxel_m_);
      thin_at_ = std::max(kFew, 2 * points_.size());
    }
  }
  const std::vector<MapPoint>& points() const { return points_; }

 private:
  static constexpr std::size_t kFew = 2'000'000;
  float voxel_m_;
  std::size_t thin_at_ = kFew;
  std::vector<MapPoint> points_;
};

struct CloudParts {
  explicit CloudParts(double voxel_m) : structure(voxel_m) {}
  std::map<EntityId, ThinnedPoints> entities;
  ThinnedPoints structure;
};

void addScan(const CNodeKeyframe& keyframe, const ScanOwners& owners,
             const std::map<EntityId, Pose3>& drawn, double voxel_m, CloudParts& parts) {
  const Pose3 T_map_lidar = keyframe.T_map_base() * keyframe.scan->T_base_lidar;
  const auto& cloud = keyframe.scan->cloud.points;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p_map = T_map_lidar * cloud[i].cast<double>();
    if (owners.isStructure(i)) {
      parts.structure.add({p_map.cast<float>()});
      continue;
    }
    const PlacedEntity* owner = owners.entity(i);
    const auto place = owner ? drawn.find(owner->entity) : drawn.end();
    if (place == drawn.end()) continue;
    const Vector3 p_entity = owner->T_map_entity.inverse() * p_map;
    parts.entities.try_emplace(owner->entity, voxel_m)
        .first->second.add({(place->second * p_entity).cast<float>(),
                            pointClass(owner->semantic_class),
                            static_cast<std::int32_t>(owner->entity.value)});
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

std::vector<MapPoint> mapCloud(const RunResult& run, const ExportParams& params) {
  const double voxel_m = params.cloud.voxel_m;
  const PointOwners& owners = pointOwners(run, params.structure, params.query);
  const auto drawn = drawnEntities(run, params);
  CloudParts parts(voxel_m);
  for (const auto& keyframe : run.graph.keyframes()) {
    if (!keyframe->scan) continue;
    addScan(*keyframe, owners.of(*keyframe), drawn, voxel_m, parts);
    parts.structure.thinWhenMany();
    for (auto& [id, points] : parts.entities) points.thinWhenMany();
  }
  std::vector<MapPoint> all;
  for (const auto& [id, part] : parts.entities)
    all.insert(all.end(), part.points().begin(), part.points().end());
  all.insert(all.end(), parts.structure.points().begin(), parts.structure.points().end());
  return voxel_m > 0 ? thinned(all, static_cast<float>(voxel_m)) : all;
}

}  // namespace dynemo
