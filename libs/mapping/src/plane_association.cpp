#include "dynemo/mapping/plane_association.h"

#include <algorithm>
#include <cmath>

#include "dynemo/graph/edge_plane.h"

namespace dynemo {
namespace {

/// Whether the part of the plane seen so far reaches to the points; the latest sightings first,
/// since they are the likeliest.
bool seenNear(const CSceneGraph& graph, const CNodePlane& plane,
              std::span<const Vector3> points_map, double max_gap_m) {
  const std::vector<EdgeId>& edges = graph.edgesOf(plane.id);
  for (auto id = edges.rbegin(); id != edges.rend(); ++id) {
    const auto* edge = dynamic_cast<const CEdgeKeyframePlane*>(graph.edgeSlots()[id->value].get());
    if (!edge) continue;
    const auto& keyframe = graph.getNode<CNodeKeyframe>(edge->nodes[0]);
    const auto seen = cellCenters(edge->patch_base, keyframe.T_map_base());
    if (withinGap(points_map, seen, max_gap_m)) return true;
  }
  return false;
}

bool alike(const Plane3& plane_map, const PlanePatch& patch_base, const Pose3& T_map_base,
           const PlaneAssociationParams& params) {
  const Vector3 normal_map = T_map_base.R * patch_base.normal;
  return plane_map.normal.dot(normal_map) > std::cos(params.max_angle_rad) &&
         std::abs(plane_map.distance(T_map_base * patch_base.center)) < params.max_offset_m;
}

Matrix3 flatness(const PlaneAssociationParams& params) {
  const double rad2 = params.flatness_sigma_rad * params.flatness_sigma_rad;
  const double m2 = params.flatness_sigma_m * params.flatness_sigma_m;
  return Vector3(rad2, rad2, m2).asDiagonal();
}

/// Squared Mahalanobis distance of an observation from a mapped plane.
double distance2(const CNodePlane& plane, const PlaneObservation& observation,
                 const KeyframePrediction& prediction, const PlaneAssociationParams& params) {
  CEdgeKeyframePlane edge;
  edge.patch_base = observation.patch_base;
  double pose[CNodePose::kStateSize], state[CNodePlane::kStateSize];
  CNodePose::poseToState(prediction.T_map_base(), pose);
  plane.readState(state);
  const double* states[] = {pose, state};
  Residual e;
  Jacobians J;
  edge.evaluate(states, e, &J);
  Eigen::Matrix<double, 3, 9> J_joint;
  J_joint << J[0], J[1];
  const Matrix3 S = J_joint * prediction.jointWith({plane.id}) * J_joint.transpose() +
                    observation.covariance + flatness(params);
  return squaredMahalanobis(e, S);
}

/// Of the difference of two mapped planes around a point.
double distance2(const CNodePlane& a, const CNodePlane& b, const Vector3& p_map,
                 const KeyframePrediction& prediction, const PlaneAssociationParams& params) {
  const SphereLog log = sphereLog(a.plane_map.normal, b.plane_map.normal);
  const auto B_a = orthogonalBasis(a.plane_map.normal), B_b = orthogonalBasis(b.plane_map.normal);
  Vector3 e;
  e << log.w, b.plane_map.distance(p_map) - a.plane_map.distance(p_map);
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  J.block<2, 2>(0, 0) = -Eigen::Matrix2d::Identity();  // for small angles between the two
  J.block<2, 2>(0, 3) = log.J_w_v * B_b;
  J.block<1, 2>(2, 0) = -p_map.transpose() * B_a;
  J.block<1, 2>(2, 3) = p_map.transpose() * B_b;
  J(2, 2) = -1.0;
  J(2, 5) = 1.0;
  const MatrixX joint = prediction.jointWith({a.id, b.id}).bottomRightCorner(6, 6);
  return squaredMahalanobis(e, J * joint * J.transpose() + 2.0 * flatness(params));
}

struct Match {
  const CNodePlane* plane;
  double distance2;
};

std::vector<Match> matches(const CSceneGraph& graph, const KeyframePrediction& prediction,
                           const PlaneObservation& observation, double gate,
                           const PlaneAssociationParams& params) {
  std::vector<Match> list;
  const auto points = cellCenters(observation.patch_base, prediction.T_map_base());
  for (const auto& plane : graph.planes()) {
    if (!prediction.knows(plane->id) ||
        !alike(plane->plane_map, observation.patch_base, prediction.T_map_base(), params)) {
      continue;
    }
    const double d2 = distance2(*plane, observation, prediction, params);
    if (d2 <= gate && seenNear(graph, *plane, points, params.max_gap_m))
      list.push_back({plane.get(), d2});
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Match& a, const Match& b) { return a.distance2 < b.distance2; });
  return list;
}

/// Whether enough of the points lie where the mapped plane has been seen, up to an offset; the
/// latest sightings first.
bool covers(const CSceneGraph& graph, const CNodePlane& plane, std::vector<Vector3> points,
            double offset_m, double min_cover) {
  const double reach_m = std::hypot(PlanePatch::kCell_m, offset_m);
  const auto may_be_left =
      static_cast<std::size_t>((1.0 - min_cover) * static_cast<double>(points.size()));
  const std::vector<EdgeId>& edges = graph.edgesOf(plane.id);
  for (auto id = edges.rbegin(); id != edges.rend() && points.size() > may_be_left; ++id) {
    const auto* edge = dynamic_cast<const CEdgeKeyframePlane*>(graph.edgeSlots()[id->value].get());
    if (!edge) continue;
    const auto& keyframe = graph.getNode<CNodeKeyframe>(edge->nodes[0]);
    eraseWithinGap(points, cellCenters(edge->patch_base, keyframe.T_map_base()), reach_m);
  }
  return points.size() <= may_be_left;
}

struct CoveredPlane {
  NodeId plane{};
  double offset_m = 0.0;
};

/// The nearest mapped plane that the observation would hide, or be hidden by, were it another.
std::optional<CoveredPlane> covered(const CSceneGraph& graph, const KeyframePrediction& prediction,
                                    const PlaneObservation& observation,
                                    const PlaneAssociationParams& params) {
  const Pose3& T = prediction.T_map_base();
  const auto points = cellCenters(observation.patch_base, T);
  const Vector3 center = T * observation.patch_base.center;
  std::optional<CoveredPlane> nearest;
  double nearest_m = params.max_slip_m;
  for (const auto& plane : graph.planes()) {
    const double offset_m = std::abs(plane->plane_map.distance(center));
    if (offset_m >= nearest_m || points.empty() || !prediction.knows(plane->id) ||
        !alike(plane->plane_map, observation.patch_base, T, params) ||
        !covers(graph, *plane, points, offset_m, params.min_cover)) {
      continue;
    }
    nearest = {plane->id, offset_m};
    nearest_m = offset_m;
  }
  return nearest;
}

/// The plane that a node is merged into, itself when it is not.
NodeId keptBy(NodeId node, const std::vector<PlaneMerge>& merges) {
  for (const PlaneMerge& merge : merges) {
    if (merge.removed == node) return keptBy(merge.kept, merges);
  }
  return node;
}

}  // namespace

void fields(FieldVisitor& v, PlaneAssociationParams& p) {
  v.number("gate_probability", p.gate_probability,
           "Chi-square(3) probability up to which a difference is noise",
           Range::between(0.5, 0.999999));
  v.angle("max_angle_deg", p.max_angle_rad, "Planes at a larger angle are never the same",
          {0.0, 90.0, true});
  v.number("max_offset_m", p.max_offset_m, "Planes further apart are never the same",
           Range::positive());
  v.number("max_gap_m", p.max_gap_m, "Distance between the seen parts of one plane",
           Range::positive());
  v.number("max_slip_m", p.max_slip_m,
           "Offset up to which a plane that covers a mapped one is the same, however certain both "
           "are; 0 for never",
           Range::nonNegative());
  v.number("min_cover", p.min_cover, "Least share of the plane that covers the mapped one",
           Range::between(0.0, 1.0));
  v.number("flatness_sigma_m", p.flatness_sigma_m, "How far walls are from flat",
           Range::nonNegative());
  v.angle("flatness_sigma_deg", p.flatness_sigma_rad, "How far walls are from flat",
          Range::nonNegative());
}

std::vector<NodeId> planeCandidates(const CSceneGraph& graph, const Pose3& T_map_base,
                                    const std::vector<PlaneObservation>& observations,
                                    const PlaneAssociationParams& params) {
  std::vector<NodeId> candidates;
  for (const auto& plane : graph.planes()) {
    const bool any = std::any_of(observations.begin(), observations.end(), [&](const auto& o) {
      return alike(plane->plane_map, o.patch_base, T_map_base, params) &&
             seenNear(graph, *plane, cellCenters(o.patch_base, T_map_base), params.max_gap_m);
    });
    if (any) candidates.push_back(plane->id);
  }
  return candidates;
}

PlaneAssociation associatePlanes(const CSceneGraph& graph, const KeyframePrediction& prediction,
                                 const std::vector<PlaneObservation>& observations,
                                 const PlaneAssociationParams& params) {
  const double gate = chiSquaredQuantile(3, params.gate_probability);
  PlaneAssociation result;
  for (const PlaneObservation& observation : observations) {
    const auto found = matches(graph, prediction, observation, gate, params);
    if (found.empty()) {
      const auto plane = covered(graph, prediction, observation, params);
      result.plane.push_back(plane ? std::optional(plane->plane) : std::nullopt);
      if (plane) {
        // Two walls face to face show the same slip, which counts once.
        auto S = result.slip.topLeftCorner<3, 3>();
        const Vector3& n = observation.patch_base.normal;
        const double unexplained_m2 = plane->offset_m * plane->offset_m - n.dot(S * n);
        if (unexplained_m2 > 0.0) S += unexplained_m2 * n * n.transpose();
      }
      continue;
    }
    const CNodePlane& best = *found.front().plane;
    const Vector3 center_map = prediction.T_map_base() * observation.patch_base.center;
    for (std::size_t i = 1; i < found.size(); ++i) {
      const CNodePlane& other = *found[i].plane;
      const NodeId a = keptBy(best.id, result.merges), b = keptBy(other.id, result.merges);
      if (a == b || distance2(best, other, center_map, prediction, params) > gate) continue;
      result.merges.push_back({std::min(a, b), std::max(a, b)});
    }
    result.plane.push_back(best.id);
  }
  for (auto& plane : result.plane) {
    if (plane) plane = keptBy(*plane, result.merges);
  }
  return result;
}

}  // namespace dynemo
