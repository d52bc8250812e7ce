#include "entity_places.h"

#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

/// Camera and LiDAR of one frame are this close in time.
constexpr double kSameFrame_s = 0.1;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What one observation shows of an entity.
struct View {
  std::vector<Vector3> points;
  Extent extent;
};

bool touch(const Extent& a, const Extent& b) {
  constexpr double kGap_m = 0.03;
  return (a.min.array() <= b.max.array() + kGap_m).all() &&
         (b.min.array() <= a.max.array() + kGap_m).all();
}

/// The largest group of views that hang together: a fragment that is the thing beside lies apart.
std::vector<View> largestGroup(std::vector<View> views) {
  std::vector<View> largest;
  while (!views.empty()) {
    std::vector<View> group{std::move(views.back())};
    views.pop_back();
    for (std::size_t k = 0; k < group.size(); ++k) {
      for (std::size_t i = 0; i < views.size();) {
        if (touch(group[k].extent, views[i].extent)) {
          group.push_back(std::move(views[i]));
          views.erase(views.begin() + static_cast<std::ptrdiff_t>(i));
        } else {
          ++i;
        }
      }
    }
    if (group.size() >= largest.size()) largest = std::move(group);
  }
  return largest;
}

/// The outermost of one side over the views, but not further than the entity usually reaches on
/// that axis: what adjoins it, as a wall or somebody who walks by, is in the fragments of a few.
double outermost(const std::vector<double>& reaches, double usual_m) {
  constexpr double kMore_m = 0.1;
  double most = -usual_m - kMore_m;
  for (const double reach : reaches)
    if (reach <= usual_m + kMore_m) most = std::max(most, reach);
  return most;
}

Extent commonExtent(const std::vector<View>& views) {
  Extent extent;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> down, up;
    for (const View& view : views) {
      down.push_back(-view.extent.min[axis]);
      up.push_back(view.extent.max[axis]);
    }
    const double usual_m = std::max(std::abs(median(down)), std::abs(median(up)));
    extent.min[axis] = -outermost(down, usual_m);
    extent.max[axis] = outermost(up, usual_m);
  }
  return extent;
}

/// Where the body of an agent has its middle: its origin, unless what was seen of it lies beside.
Vector2 bodyAxis(const Extent& extent) {
  constexpr double kUnseen_m = 0.15;  // the far half of a body
  const Vector2 low = extent.min.head<2>().array() - kUnseen_m;
  const Vector2 high = extent.max.head<2>().array() + kUnseen_m;
  if (Eigen::AlignedBox2d(low, high).contains(Vector2::Zero())) return Vector2::Zero();
  return 0.5 * (low + high);
}

/// Nearly all points of a view are no further from the axis; the median of the views, since
/// whoever walks beside is in the fragments of a few.
double bodyRadius(const std::vector<View>& views, const Vector2& axis) {
  std::vector<double> radii;
  for (const View& view : views) {
    std::vector<double> distances;
    for (const Vector3& p : view.points) distances.push_back((p.head<2>() - axis).norm());
    const auto most = distances.begin() +
                      static_cast<std::ptrdiff_t>(distances.size() - 1 - distances.size() / 50);
    std::nth_element(distances.begin(), most, distances.end());
    radii.push_back(*most);
  }
  return median(radii);
}

/// Of the observations that show enough points; of all together when none does.
std::vector<View> viewsOf(const CSceneGraph& graph, const EntityTrack& track) {
  std::vector<View> views;
  const auto add = [&](const EntityTrack& observations) {
    std::vector<Vector3> points = fragmentPoints(graph, observations);
    if (const auto extent = extentOf(points)) views.push_back({std::move(points), *extent});
  };
  for (const auto& node : track) add({node});
  if (views.empty()) add(track);
  return views;
}

}  // namespace

bool EntityVolume::contains(const Vector3& p) const {
  if (p.z() < extent.min.z() || p.z() > extent.max.z()) return false;
  if (cylinder) return (p.head<2>() - axis).squaredNorm() <= radius_m * radius_m;
  return (p.head<2>().array() >= extent.min.head<2>().array()).all() &&
         (p.head<2>().array() <= extent.max.head<2>().array()).all();
}

double EntityVolume::reach_m() const {
  const Vector3 corner = extent.min.cwiseAbs().cwiseMax(extent.max.cwiseAbs());
  return cylinder ? std::hypot(axis.norm() + radius_m, corner.z()) : corner.norm();
}

std::optional<EntityVolume> volumeOf(const CSceneGraph& graph, const EntityTrack& track,
                                     double margin_m) {
  const std::vector<View> views = largestGroup(viewsOf(graph, track));
  if (views.empty()) return std::nullopt;
  const Extent extent = commonExtent(views);
  EntityVolume volume;
  volume.extent = {extent.min.array() - margin_m, extent.max.array() + margin_m};
  volume.cylinder = track.front()->semantic_class == SemanticClass::kAgent;
  if (volume.cylinder) {
    volume.axis = bodyAxis(extent);
    volume.radius_m = bodyRadius(views, volume.axis) + margin_m;
  }
  return volume;
}

EntityPlaces::EntityPlaces(const CSceneGraph& graph, const std::map<NodeId, Matrix6>& covariances,
                           const StructureParams& params, const QueryParams& query)
    : agent_gap_s_(params.agent_gap_s) {
  for (const auto& [id, track] : graph.tracks()) {
    const auto volume = volumeOf(graph, track, params.margin_m);
    if (!volume) continue;
    if (track.front()->semantic_class == SemanticClass::kAgent) {
      agents_.push_back({&track, *volume, {}});
    } else {
      objects_.push_back({&track, *volume, staysOf(track, covariances, query)});
    }
  }
}

const EntityVolume* EntityPlaces::volume(EntityId entity) const {
  for (const auto* list : {&objects_, &agents_}) {
    for (const Known& known : *list)
      if (known.track->front()->entity == entity) return &known.volume;
  }
  return nullptr;
}

EntityPlace EntityPlaces::placed(const Known& known, const Pose3& T_map_entity) const {
  const CNodeEntity& node = *known.track->front();
  return {{node.entity, node.semantic_class, T_map_entity}, known.volume, known.volume.reach_m()};
}

std::vector<EntityPlace> EntityPlaces::objectsAt(Stamp at) const {
  std::vector<EntityPlace> places;
  for (const Known& object : objects_) {
    const std::vector<Stay>& stays = object.stays;
    for (std::size_t i = 0; i < stays.size(); ++i) {
      if (i > 0 && at <= stays[i - 1].last_seen) continue;
      if (i + 1 < stays.size() && at >= stays[i + 1].first_seen) continue;
      places.push_back(placed(object, stays[i].T_map_entity));
    }
  }
  return places;
}

std::vector<EntityPlace> EntityPlaces::agentsAt(Stamp at) const {
  std::vector<EntityPlace> places;
  for (const Known& agent : agents_) {
    const CNodeEntity *before = nullptr, *after = nullptr;
    for (const auto& node : *agent.track) {
      if (node->stamp <= at) before = node.get();
      if (node->stamp >= at && !after) after = node.get();
    }
    const double before_s = before ? secondsBetween(before->stamp, at) : agent_gap_s_;
    const double after_s = after ? secondsBetween(at, after->stamp) : agent_gap_s_;
    if (before && before_s <= std::min(after_s, kSameFrame_s)) {
      places.push_back(placed(agent, before->T_map_entity()));
    } else if (after && after_s <= kSameFrame_s) {
      places.push_back(placed(agent, after->T_map_entity()));
    } else if (before && after && before_s + after_s <= agent_gap_s_) {
      places.push_back(placed(agent, interpolate(before->T_map_entity(), after->T_map_entity(),
                                                 before_s / (before_s + after_s))));
    }
  }
  return places;
}

}  // namespace dynemo
