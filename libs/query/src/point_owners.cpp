#include "dynemo/query/point_owners.h"

#include <algorithm>

#include "entity_places.h"
#include "mapped_surfaces.h"
#include "seen_through.h"

namespace dynemo {
namespace {

/// While a scan is judged.
constexpr std::int32_t kOnFloor = -3, kOnPlane = -4;

/// One scan of the map.
struct MapScan {
  const CNodeKeyframe& keyframe;
  Pose3 T_map_lidar;
  std::vector<Vector3> points_map;
};

class Judge {
 public:
  Judge(const CSceneGraph& graph, const std::map<NodeId, Matrix6>& covariances,
        const StructureParams& params, const QueryParams& query)
      : graph_(graph),
        params_(params),
        surfaces_(graph, params.surface_tolerance_m),
        places_(graph, covariances, params, query),
        seen_through_(params) {
    for (const auto& [id, track] : graph.tracks()) {
      for (const auto& node : track) observed_[node->keyframe].push_back(node.get());
    }
    // In the order in which they were seen: the later one has a point that two fragments share.
    for (auto& [keyframe, nodes] : observed_) {
      std::sort(nodes.begin(), nodes.end(),
                [](const CNodeEntity* a, const CNodeEntity* b) { return a->id < b->id; });
    }
  }

  std::map<NodeId, ScanOwners> owners() {
    if (params_.seen_through) {
      forEachScan([&](const MapScan& scan) {
        surfaces_.look(beamsOf(scan, known(scan)), scan.T_map_lidar, params_);
      });
      surfaces_.eraseSeenThrough(params_);
    }
    std::map<NodeId, ScanOwners> scans;
    forEachScan([&](const MapScan& scan) { scans.emplace(scan.keyframe.id, known(scan)); });
    if (params_.seen_through) lookAround(scans);
    forEachScan([&](const MapScan& scan) { finish(scan, scans.at(scan.keyframe.id)); });
    return scans;
  }

 private:
  template <class Action>
  void forEachScan(const Action& action) const {
    for (const auto& keyframe : graph_.keyframes()) {
      if (!keyframe->scan) continue;
      MapScan scan{*keyframe, keyframe->T_map_base() * keyframe->scan->T_base_lidar, {}};
      scan.points_map.reserve(keyframe->scan->cloud.size());
      for (const auto& p : keyframe->scan->cloud.points)
        scan.points_map.push_back(scan.T_map_lidar * p.cast<double>());
      action(scan);
    }
  }

  /// What needs no other scan: fragments, surfaces, objects that stand there.
  ScanOwners known(const MapScan& scan) const {
    ScanOwners owners;
    owners.owner.assign(scan.points_map.size(), ScanOwners::kStructure);
    takeFragments(scan, owners);
    if (!params_.volumes && !params_.seen_through) return owners;
    for (std::size_t i = 0; i < scan.points_map.size(); ++i) {
      if (owners.owner[i] != ScanOwners::kStructure) continue;
      const auto kind = surfaces_.at(scan.points_map[i]);
      if (kind == MappedSurfaces::Kind::kFloor) owners.owner[i] = kOnFloor;
      if (kind == MappedSurfaces::Kind::kPlane) owners.owner[i] = kOnPlane;
    }
    if (!params_.volumes) return owners;
    for (const EntityPlace& place : places_.objectsAt(scan.keyframe.stamp))
      fill(place, scan, owners);
    return owners;
  }

  void takeFragments(const MapScan& scan, ScanOwners& owners) const {
    const auto seen = observed_.find(scan.keyframe.id);
    if (seen == observed_.end()) return;
    for (const CNodeEntity* node : seen->second) {
      const EntityVolume* volume = params_.volumes ? places_.volume(node->entity) : nullptr;
      const Pose3 T_entity_map = node->T_map_entity().inverse();
      for (const std::uint32_t i : node->fragment) {
        if (i >= scan.points_map.size()) continue;
        if (volume && !volume->contains(T_entity_map * scan.points_map[i])) continue;
        owners.owner[i] = static_cast<std::int32_t>(owners.entities.size());
      }
      owners.entities.push_back({node->entity, node->semantic_class, node->T_map_entity()});
    }
  }

  /// Gives the points that are inside of a place to its entity, except where something is known to
  /// last.
  void fill(const EntityPlace& place, const MapScan& scan, ScanOwners& owners) const {
    const Pose3& T_map_entity = place.placed.T_map_entity;
    const Pose3 T_entity_map = T_map_entity.inverse();
    const double reach_m2 = place.reach_m * place.reach_m;
    const auto index = static_cast<std::int32_t>(owners.entities.size());
    bool any = false;
    for (std::size_t i = 0; i < scan.points_map.size(); ++i) {
      const Vector3& p_map = scan.points_map[i];
      if (owners.owner[i] != ScanOwners::kStructure) continue;
      if ((p_map - T_map_entity.t).squaredNorm() > reach_m2) continue;
      if (!place.volume.contains(T_entity_map * p_map)) continue;
      if (seen_through_.at(p_map) == Permanence::kLasting) continue;
      owners.owner[i] = index;
      any = true;
    }
    if (any) owners.entities.push_back(place.placed);
  }

  static BeamGrid beamsOf(const MapScan& scan, const ScanOwners& owners) {
    std::vector<BeamEnd> ends;
    ends.reserve(owners.owner.size());
    for (const std::int32_t owner : owners.owner) {
      ends.push_back(owner >= 0          ? BeamEnd::kEntity
                     : owner == kOnFloor ? BeamEnd::kFloor
                                         : BeamEnd::kThing);
    }
    return {scan.keyframe.scan->cloud, ends};
  }

  void lookAround(const std::map<NodeId, ScanOwners>& scans) {
    forEachScan([&](const MapScan& scan) {
      const auto& owner = scans.at(scan.keyframe.id).owner;
      for (std::size_t i = 0; i < owner.size(); ++i)
        if (owner[i] == ScanOwners::kStructure) seen_through_.addPoint(scan.points_map[i]);
    });
    seen_through_.prepare();
    forEachScan([&](const MapScan& scan) {
      seen_through_.look(beamsOf(scan, scans.at(scan.keyframe.id)), scan.T_map_lidar);
    });
  }

  void finish(const MapScan& scan, ScanOwners& owners) const {
    if (params_.volumes) {
      for (const EntityPlace& place : places_.agentsAt(scan.keyframe.stamp))
        fill(place, scan, owners);
    }
    for (std::size_t i = 0; i < owners.owner.size(); ++i) {
      std::int32_t& owner = owners.owner[i];
      if (owner <= kOnFloor) {
        owner = ScanOwners::kStructure;
      } else if (owner == ScanOwners::kStructure &&
                 seen_through_.at(scan.points_map[i]) == Permanence::kPassing) {
        owner = ScanOwners::kPassing;
      }
    }
  }

  const CSceneGraph& graph_;
  const StructureParams& params_;
  MappedSurfaces surfaces_;
  EntityPlaces places_;
  SeenThrough seen_through_;
  std::map<NodeId, std::vector<const CNodeEntity*>> observed_;
};

}  // namespace

PointOwners::PointOwners(const CSceneGraph& graph,
                         const std::map<NodeId, Matrix6>& entity_covariances,
                         const StructureParams& params, const QueryParams& query)
    : scans_(Judge(graph, entity_covariances, params, query).owners()) {}

}  // namespace dynemo
