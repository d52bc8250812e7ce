#include "recovered_edge.h"

#include <algorithm>
#include <cmath>
#include <typeinfo>

#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/edge_summary.h"

namespace dynemo::life {
namespace {

bool isNeighbours(const Departure& d, NodeId a, NodeId b) {
  return d.before && d.after && std::minmax(a, b) == std::minmax(*d.before, *d.after);
}

/// The motion model of the edges that tie the leaving observation of the entity to others.
std::string motionModelOf(const CSceneGraph& graph, const Departure& departure, EntityId entity) {
  for (const EdgeId id : departure.factors) {
    const auto* edge = dynamic_cast<const CEdgeIntraEntity*>(graph.edgeSlots()[id.value].get());
    if (edge && graph.getNode<CNodeEntity>(edge->nodes[1]).entity == entity)
      return edge->motion_model;
  }
  return "static_object";
}

std::shared_ptr<CEdgeRelativePose> relativeEdge(const CSceneGraph& graph,
                                                const Departure& departure, const CNodePose& a,
                                                const CNodePose& b) {
  std::shared_ptr<CEdgeRelativePose> edge;
  const auto* entity_a = dynamic_cast<const CNodeEntity*>(&a);
  const auto* entity_b = dynamic_cast<const CNodeEntity*>(&b);
  if (isNeighbours(departure, a.id, b.id)) {
    edge = std::make_shared<CEdgeOdometry>();
  } else if (entity_a && entity_b && entity_a->entity == entity_b->entity) {
    auto intra = std::make_shared<CEdgeIntraEntity>();
    intra->motion_model = motionModelOf(graph, departure, entity_a->entity);
    edge = intra;
  } else {
    edge = std::make_shared<CEdgeSummary>();
  }
  edge->T_1_2 = a.T_map_node.inverse() * b.T_map_node;
  return edge;
}

/// The leaving keyframe's sightings of a plane or of the ground.
std::vector<const CEdgePlaneMeasurement*> sightings(const CSceneGraph& graph,
                                                    const Departure& departure, NodeId seen) {
  std::vector<const CEdgePlaneMeasurement*> all;
  for (const EdgeId id : departure.factors) {
    const auto* edge =
        dynamic_cast<const CEdgePlaneMeasurement*>(graph.edgeSlots()[id.value].get());
    if (edge && edge->nodes[1] == seen) all.push_back(edge);
  }
  return all;
}

/// Measures the plane around the point of it that the leaving keyframe measured.
template <class Edge>
CEdgeBase::Ptr planeEdge(const CSceneGraph& graph, const Departure& departure,
                         const CNodeKeyframe& keyframe, const Plane3& plane_map, NodeId seen) {
  const auto seen_by = sightings(graph, departure, seen);
  if (seen_by.empty()) return nullptr;
  const Pose3& T_map_from = graph.getNode<CNodeKeyframe>(departure.keyframe).T_map_base();
  auto edge = std::make_shared<Edge>();
  const Plane3 plane_base = keyframe.T_map_base().inverse() * plane_map;
  const Vector3 center =
      keyframe.T_map_base().inverse() * (T_map_from * seen_by.front()->patch_base.center);
  edge->patch_base.normal = plane_base.normal;
  edge->patch_base.center = center - plane_base.distance(center) * plane_base.normal;
  return edge;
}

CEdgeBase::Ptr heightEdge(const CNodeFloor& floor, const CNodeEntity& entity) {
  auto edge = std::make_shared<CEdgeFloorEntity>();
  edge->offset_m = floor.level_m - entity.T_map_entity().t.z();
  return edge;
}

}  // namespace

CEdgeBase::Ptr edgeBetween(const CSceneGraph& graph, const Departure& departure, const CNodeBase& a,
                           const CNodeBase& b) {
  const auto connect = [](CEdgeBase::Ptr edge, NodeId first, NodeId second) {
    if (edge) edge->nodes = {first, second};
    return edge;
  };
  const auto *pose_a = dynamic_cast<const CNodePose*>(&a),
             *pose_b = dynamic_cast<const CNodePose*>(&b);
  if (pose_a && pose_b)
    return connect(relativeEdge(graph, departure, *pose_a, *pose_b), a.id, b.id);
  if (pose_b) return edgeBetween(graph, departure, b, a);
  const auto* keyframe = dynamic_cast<const CNodeKeyframe*>(&a);
  const auto* floor = dynamic_cast<const CNodeFloor*>(&b);
  if (const auto* plane = dynamic_cast<const CNodePlane*>(&b); plane && keyframe) {
    return connect(
        planeEdge<CEdgeKeyframePlane>(graph, departure, *keyframe, plane->plane_map, b.id), a.id,
        b.id);
  }
  if (floor && keyframe) {
    const Plane3 ground = {Vector3::UnitZ(), -floor->level_m};
    return connect(planeEdge<CEdgeFloorGround>(graph, departure, *keyframe, ground, b.id), a.id,
                   b.id);
  }
  if (const auto* entity = dynamic_cast<const CNodeEntity*>(&a); entity && floor)
    return connect(heightEdge(*floor, *entity), b.id, a.id);
  return nullptr;
}

const CEdgeBase* sameEdge(const CSceneGraph& graph, const CEdgeBase& edge) {
  for (const EdgeId id : graph.edgesOf(edge.nodes.back())) {
    const CEdgeBase* other = graph.edgeSlots()[id.value].get();
    if (other->kernel.type == KernelType::kNone && other->nodes == edge.nodes &&
        typeid(*other) == typeid(edge))
      return other;
  }
  return nullptr;
}

void measureLike(const CEdgeBase& other, CEdgeBase& edge) {
  auto* plane = dynamic_cast<CEdgePlaneMeasurement*>(&edge);
  if (!plane) return;
  const auto& seen = dynamic_cast<const CEdgePlaneMeasurement&>(other);
  const Plane3 plane_base = plane->patch_base.plane();
  const Vector3& center = seen.patch_base.center;
  plane->patch_base.center = center - plane_base.distance(center) * plane_base.normal;
  plane->patch_base.cells = seen.patch_base.cells;
  plane->point_count = seen.point_count;
}

void shiftMeasurement(CEdgeBase& edge, const VectorX& d) {
  if (auto* relative = dynamic_cast<CEdgeRelativePose*>(&edge)) {
    relative->T_1_2 = relative->T_1_2.retract(d);
  } else if (auto* plane = dynamic_cast<CEdgePlaneMeasurement*>(&edge)) {
    PlanePatch& patch = plane->patch_base;
    patch.center -= d[2] * patch.normal;
    patch.normal = sphereExp(patch.normal, d.head<2>());
  } else {
    dynamic_cast<CEdgeFloorEntity&>(edge).offset_m += d[0];
  }
}

void takeSight(const CSceneGraph& graph, const Departure& departure, CEdgeBase& edge) {
  auto* to = dynamic_cast<CEdgeKeyframePlane*>(&edge);
  if (!to) return;
  const Pose3 T_to_from = graph.getNode<CNodeKeyframe>(to->nodes[0]).T_map_base().inverse() *
                          graph.getNode<CNodeKeyframe>(departure.keyframe).T_map_base();
  PlanePatch& patch = to->patch_base;
  const Eigen::Matrix<double, 3, 2> B = orthogonalBasis(patch.normal) / PlanePatch::kCell_m;
  for (const CEdgePlaneMeasurement* from : sightings(graph, departure, to->nodes[1])) {
    to->point_count += from->point_count;
    for (const Vector3& middle : cellCenters(from->patch_base, T_to_from)) {
      const Vector2 at = B.transpose() * (middle - patch.center);
      if (at.cwiseAbs().maxCoeff() > 32000.0) continue;
      patch.cells.push_back({static_cast<std::int16_t>(std::floor(at.x())),
                             static_cast<std::int16_t>(std::floor(at.y()))});
    }
  }
  std::sort(patch.cells.begin(), patch.cells.end());
  patch.cells.erase(std::unique(patch.cells.begin(), patch.cells.end()), patch.cells.end());
}

}  // namespace dynemo::life
