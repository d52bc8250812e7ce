#include "dynemo/query/point_owners.h"

#include <algorithm>

#include "entity_places.h"
#include "mapped_surfaces.h"
#include "seen_through.h"

namespace dynemo {
namespace {

/// While a scan is judged.
constexpr std::int32_t kOnFloor = -3, kOnPlane = -4;

using PointIndices = std::vector<std::uint32_t>;

/// One scan of the map.
struct MapScan {
  const CNodeKeyframe& keyframe;
  std::size_t index;  ///< among the scans
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
    std::map<NodeId, ScanOwners> scans;
    forEachScan([&](const MapScan& scan) { scans.emplace(scan.keyframe.id, known(scan)); });
    if (params_.seen_through) {
      const std::vector<Viewpoint> views = viewpoints();
      lookAtSurfaces(views, scans);
      lookAround(views, scans);
    }
    forEachScan([&](const MapScan& scan) { finish(scan, scans.at(scan.keyframe.id)); });
    return scans;
  }

 private:
  template <class Action>
  void forEachScan(const Action& action) const {
    std::size_t index = 0;
    for (const auto& keyframe : graph_.keyframes()) {
      if (!keyframe->scan) continue;
      MapScan scan{*keyframe, index++, keyframe->T_map_base() * keyframe->scan->T_base_lidar, {}};
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
    fillObjects(scan, owners, unknown(owners));
    return owners;
  }

  static PointIndices unknown(const ScanOwners& owners) {
    PointIndices points;
    for (std::uint32_t i = 0; i < owners.owner.size(); ++i)
      if (owners.owner[i] == ScanOwners::kStructure) points.push_back(i);
    return points;
  }

  void fillObjects(const MapScan& scan, ScanOwners& owners, const PointIndices& points) const {
    if (points.empty()) return;
    for (const EntityPlace& place : places_.objectsAt(scan.keyframe.stamp))
      fill(place, scan, points, owners);
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

  /// Gives those of the points that are inside of a place to its entity, except where something is
  /// known to last.
  void fill(const EntityPlace& place, const MapScan& scan, const PointIndices& points,
            ScanOwners& owners) const {
    const Pose3& T_map_entity = place.placed.T_map_entity;
    const Pose3 T_entity_map = T_map_entity.inverse();
    const double reach_m2 = place.reach_m * place.reach_m;
    const auto index = static_cast<std::int32_t>(owners.entities.size());
    bool any = false;
    for (const std::uint32_t i : points) {
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

  std::vector<Viewpoint> viewpoints() const {
    std::vector<Viewpoint> views;
    forEachScan([&](const MapScan& scan) {
      views.push_back({scan.T_map_lidar.t, scan.keyframe.stamp});
    });
    return views;
  }

  void look(PlaceSights& sights, const std::map<NodeId, ScanOwners>& scans) const {
    do {
      forEachScan([&](const MapScan& scan) {
        if (sights.looks(scan.index))
          sights.look(scan.index, beamsOf(scan, scans.at(scan.keyframe.id)), scan.T_map_lidar);
      });
    } while (sights.lookCloser());
  }

  /// Only what is left of the mapped planes tells structure.
  void lookAtSurfaces(const std::vector<Viewpoint>& views, std::map<NodeId, ScanOwners>& scans) {
    surfaces_.prepare(views, params_);
    look(surfaces_.sights(), scans);
    if (!surfaces_.eraseSeenThrough()) return;
    forEachScan([&](const MapScan& scan) {
      ScanOwners& owners = scans.at(scan.keyframe.id);
      PointIndices freed;
      for (std::uint32_t i = 0; i < owners.owner.size(); ++i) {
        if (owners.owner[i] != kOnPlane) continue;
        if (surfaces_.at(scan.points_map[i]) != MappedSurfaces::Kind::kNone) continue;
        owners.owner[i] = ScanOwners::kStructure;
        freed.push_back(i);
      }
      if (params_.volumes) fillObjects(scan, owners, freed);
    });
  }

  void lookAround(const std::vector<Viewpoint>& views, const std::map<NodeId, ScanOwners>& scans) {
    forEachScan([&](const MapScan& scan) {
      const auto& owner = scans.at(scan.keyframe.id).owner;
      for (std::size_t i = 0; i < owner.size(); ++i)
        if (owner[i] == ScanOwners::kStructure) seen_through_.addPoint(scan.points_map[i]);
    });
    seen_through_.prepare(views);
    look(seen_through_.sights(), scans);
  }

  void finish(const MapScan& scan, ScanOwners& owners) const {
    if (params_.volumes) {
      const PointIndices points = unknown(owners);
      for (const EntityPlace& place : places_.agentsAt(scan.keyframe.stamp))
        fill(place, scan, points, owners);
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
