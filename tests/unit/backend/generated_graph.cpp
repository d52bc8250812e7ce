#include "generated_truth.h"

#include <cmath>
#include <numbers>

#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo::test {
namespace {

constexpr double kStorey_m = 3.2;
constexpr double kOdometry_m = 0.03, kOdometry_rad = 0.008;
constexpr double kDetection_m = 0.03, kDetection_rad = 0.03;
constexpr double kPlane_m = 0.01, kPlane_rad = 0.01;
constexpr int kWalls = 4;
constexpr int kObjectsPerFloor = 24;
constexpr std::int64_t kAgent = 1'000'000;

template <class Edge>
std::shared_ptr<Edge> addEdge(const CSceneGraph& graph, GraphDelta& delta,
                              std::vector<NodeId> nodes) {
  auto edge = std::make_shared<Edge>();
  edge->id = {graph.nextEdgeId().value + delta.edges.size()};
  edge->nodes = std::move(nodes);
  delta.edges.push_back(edge);
  return edge;
}

template <class Node>
std::shared_ptr<Node> addNode(const CSceneGraph& graph, GraphDelta& delta) {
  auto node = std::make_shared<Node>();
  node->id = {graph.nextNodeId().value + delta.nodes.size()};
  delta.nodes.push_back(node);
  return node;
}

int storeyAt(const WorldParams& params, int k) {
  const int floor = k / (params.keyframes_per_lap * params.laps_per_floor);
  return params.storeys > 0 ? floor % params.storeys : floor;
}

/// The keyframe of that frame_index, or, when it has left the graph, the nearest of earlier ones;
/// null when there is none nearby.
const CNodeKeyframe* stillThere(const CSceneGraph& graph, const WorldParams& params, int k) {
  constexpr double kNear_m = 1.5;
  const CNodeKeyframe* nearest = nullptr;
  double least_m = kNear_m;
  for (auto it = graph.keyframes().rbegin(); it != graph.keyframes().rend(); ++it) {
    const auto other = static_cast<int>((*it)->frame_index);
    if (other > k) continue;
    const double apart_m = (trueRobotPose(params, other).t - trueRobotPose(params, k).t).norm();
    if (apart_m >= least_m) continue;
    nearest = it->get();
    if (other == k) break;
    least_m = apart_m;
  }
  return nearest;
}

}  // namespace

Pose3 trueRobotPose(const WorldParams& params, int k) {
  const double turn = 2.0 * std::numbers::pi * k / params.keyframes_per_lap;
  const double z = kStorey_m * storeyAt(params, k);
  return Pose3::fromYawPitchRoll(10.0 * std::cos(turn), 7.0 * std::sin(turn), z,
                                 turn + 0.5 * std::numbers::pi, 0.05 * std::sin(3 * turn),
                                 0.04 * std::cos(2 * turn));
}

double GeneratedWorld::gauss() {
  const auto uniform = [this] { return (static_cast<double>(rng_() >> 11) + 0.5) * 0x1.0p-53; };
  const double r = std::sqrt(-2.0 * std::log(uniform()));
  return r * std::cos(2.0 * std::numbers::pi * uniform());
}

Pose3 GeneratedWorld::noisy(const Pose3& T, double sigma_m, double sigma_rad) {
  Vector6 d;
  for (int i = 0; i < 6; ++i) d[i] = (i < 3 ? sigma_m : sigma_rad) * gauss();
  return T.retract(d);
}

int GeneratedWorld::floorAt(int k) const { return storeyAt(params_, k); }

int GeneratedWorld::lastVisit(int k) const {
  const int lap_ago = k - params_.keyframes_per_lap;
  if (lap_ago >= 0 && floorAt(lap_ago) == floorAt(k)) return lap_ago;
  if (params_.storeys == 0) return -1;
  return lap_ago - params_.keyframes_per_lap * params_.laps_per_floor * (params_.storeys - 1);
}

Pose3 GeneratedWorld::robotAt(int k) const { return trueRobotPose(params_, k); }

Pose3 GeneratedWorld::objectPose(int floor, int index) const {
  const double turn = 2.0 * std::numbers::pi * index / kObjectsPerFloor;
  return Pose3::fromYawPitchRoll(12.0 * std::cos(turn), 9.0 * std::sin(turn),
                                 kStorey_m * floor + 0.3 + 0.1 * (index % 7), 2.0 * turn,
                                 0.3 * index, -0.2 * index);
}

Pose3 GeneratedWorld::agentPose(int k) const {
  return robotAt(k) * Pose3::fromYawPitchRoll(2.0, 0.3 * std::sin(0.2 * k), 0.1, 0.1, 0.0, 0.2);
}

RobustKernel GeneratedWorld::detectionKernel() {
  if (!params_.outliers) return {};
  static constexpr KernelType kTypes[] = {KernelType::kHuber, KernelType::kCauchy,
                                          KernelType::kNone, KernelType::kGemanMcClure,
                                          KernelType::kTukey};
  // Redescending kernels get a width at which these graphs have one minimum nearby.
  const KernelType type = kTypes[rng_() % 5];
  const bool redescending = type == KernelType::kTukey || type == KernelType::kGemanMcClure;
  return {type, redescending ? 20.0 : 1.5};
}

void GeneratedWorld::observe(const CSceneGraph& graph, EntityId entity, const Pose3& T_map_entity,
                             SemanticClass c, NodeId keyframe, const Pose3& T_map_base_estimate,
                             GraphDelta& delta) {
  const Pose3 T_base_entity = robotAt(k_).inverse() * T_map_entity;
  const bool wrong = params_.outliers && rng_() % 16 == 0;
  auto node = addNode<CNodeEntity>(graph, delta);
  node->entity = entity;
  node->name = "entity " + std::to_string(entity.value);
  node->semantic_class = c;
  node->keyframe = keyframe;
  node->stamp = {1'000'000'000LL * k_};
  auto detection = addEdge<CEdgeKeyframeEntity>(graph, delta, {keyframe, node->id});
  detection->T_1_2 = noisy(T_base_entity, wrong ? 0.2 : kDetection_m, kDetection_rad);
  detection->setCovariance(isotropicCovariance(kDetection_m, kDetection_rad));
  detection->kernel = detectionKernel();
  if (detection->kernel.type == KernelType::kNone)
    detection->T_1_2 = noisy(T_base_entity, kDetection_m, kDetection_rad);
  node->T_map_node = node->T_map_node_first = T_map_base_estimate * detection->T_1_2;

  const CNodeEntity* before = graph.lastObservation(entity);
  if (c == SemanticClass::kAgent) return constrainAgent(graph, *node, delta);
  if (before) {
    auto intra = addEdge<CEdgeIntraEntity>(graph, delta, {before->id, node->id});
    intra->motion_model = "static_object";
    intra->setCovariance(isotropicCovariance(0.02, 0.035));
    if (params_.outliers) intra->kernel = {KernelType::kHuber, 1.345};
  }
  const NodeId floor = floorNode(graph, delta);
  auto height = addEdge<CEdgeFloorEntity>(graph, delta, {floor, node->id});
  height->offset_m = kStorey_m * floorAt(k_) - T_map_entity.t.z() + 0.01 * gauss();
  height->setCovariance(MatrixX::Constant(1, 1, 0.05 * 0.05));
}

void GeneratedWorld::constrainAgent(const CSceneGraph& graph, const CNodeEntity& newest,
                                    GraphDelta& delta) {
  // Nobody walks from the last storey to the first in a second.
  if (params_.storeys > 0 && k_ >= 2 && floorAt(k_ - 2) != floorAt(k_)) return;
  const auto it = graph.tracks().find(newest.entity);
  if (it == graph.tracks().end()) return;
  const auto& track = it->second;
  auto line = addEdge<CEdgeAgentLine>(graph, delta, {track.back()->id, newest.id});
  line->direction_entity = (agentPose(k_ - 1).inverse() * agentPose(k_)).t.normalized();
  line->setCovariance(MatrixX::Identity(2, 2) * 0.25);
  if (track.size() < 2) return;
  auto velocity = addEdge<CEdgeAgentVelocity>(
      graph, delta, {track[track.size() - 2]->id, track.back()->id, newest.id});
  velocity->dt_12_s = 1.1;
  velocity->dt_23_s = 0.9;
  velocity->setCovariance(MatrixX::Identity(3, 3) * 0.09);
  velocity->kernel = params_.outliers ? RobustKernel{KernelType::kCauchy, 2.0} : RobustKernel{};
}

NodeId GeneratedWorld::floorNode(const CSceneGraph& graph, GraphDelta& delta) {
  const auto index = static_cast<std::size_t>(floorAt(k_));
  if (index < graph.floors().size()) return graph.floors()[index]->id;
  for (const auto& node : delta.nodes) {
    if (dynamic_cast<const CNodeFloor*>(node.get())) return node->id;
  }
  auto floor = addNode<CNodeFloor>(graph, delta);
  floor->level_m = floor->level_first_m = kStorey_m * static_cast<double>(index) + 0.05 * gauss();
  if (params_.floor_prior) {
    auto prior = addEdge<CEdgeFloorPrior>(graph, delta, {floor->id});
    prior->level_m = floor->level_m;
    prior->setCovariance(MatrixX::Constant(1, 1, 0.04));
  }
  return floor->id;
}

Plane3 GeneratedWorld::wall(int floor, int index) const {
  const double turn = 0.5 * std::numbers::pi * index + 0.2 * floor;
  const Vector3 n(-std::cos(turn), -std::sin(turn), 0.0);
  return {n, 15.0};
}

PlanePatch GeneratedWorld::measured(const Plane3& plane_map) {
  const Plane3 plane = robotAt(k_).inverse() * plane_map;
  PlanePatch patch;
  patch.normal = sphereExp(plane.normal, Vector2(kPlane_rad * gauss(), kPlane_rad * gauss()));
  const Vector3 aside = orthogonalBasis(plane.normal) * Vector2(gauss(), gauss());
  patch.center = aside - (plane.distance(aside) + kPlane_m * gauss()) * plane.normal;
  return patch;
}

template <class Edge>
void GeneratedWorld::seePlane(const CSceneGraph& graph, GraphDelta& delta, NodeId keyframe,
                              NodeId seen, const Plane3& plane_map) {
  auto edge = addEdge<Edge>(graph, delta, {keyframe, seen});
  edge->patch_base = measured(plane_map);
  edge->point_count = 200;
  edge->setCovariance(
      Vector3(kPlane_rad * kPlane_rad, kPlane_rad * kPlane_rad, kPlane_m * kPlane_m).asDiagonal());
  if (params_.outliers) edge->kernel = {KernelType::kCauchy, 3.0};
}

void GeneratedWorld::seeStructure(const CSceneGraph& graph, GraphDelta& delta,
                                  const CNodeKeyframe& keyframe) {
  const int floor = floorAt(k_);
  const double level_m = kStorey_m * floor;
  seePlane<CEdgeFloorGround>(graph, delta, keyframe.id, floorNode(graph, delta),
                             {Vector3::UnitZ(), -level_m});
  const int index = k_ % kWalls;
  const Plane3 plane_map = wall(floor, index);
  const auto [it, unknown] = walls_.try_emplace({floor, index});
  if (unknown) {
    auto node = addNode<CNodePlane>(graph, delta);
    node->plane_map = node->plane_map_first =
        keyframe.T_map_node * (robotAt(k_).inverse() * plane_map);
    it->second = node->id;
    const auto known = [&](int other) { return walls_.find({floor, other}); };
    if (const auto opposite = known((index + 2) % kWalls); opposite != walls_.end()) {
      auto edge = addEdge<CEdgePlaneParallel>(graph, delta, {opposite->second, node->id});
      edge->setCovariance(1e-4 * MatrixX::Identity(3, 3));
    }
    if (const auto beside = known((index + 3) % kWalls); beside != walls_.end()) {
      auto edge = addEdge<CEdgePlanePerpendicular>(graph, delta, {beside->second, node->id});
      edge->setCovariance(1e-4 * MatrixX::Identity(1, 1));
    }
  }
  seePlane<CEdgeKeyframePlane>(graph, delta, keyframe.id, it->second, plane_map);
}

GraphDelta GeneratedWorld::nextKeyframe(const CSceneGraph& graph) {
  GraphDelta delta;
  auto keyframe = addNode<CNodeKeyframe>(graph, delta);
  keyframe->stamp = {1'000'000'000LL * k_};
  keyframe->frame_index = static_cast<std::uint64_t>(k_);
  if (k_ == 0) {
    keyframe->T_map_node = robotAt(0);
    if (params_.pose_prior) {
      auto prior = addEdge<CEdgePosePrior>(graph, delta, {keyframe->id});
      prior->T_map_node = robotAt(0);
      prior->setCovariance(isotropicCovariance(0.01, 0.01));
    }
  } else {
    const CNodeKeyframe& last = *graph.keyframes().back();
    auto odometry = addEdge<CEdgeOdometry>(graph, delta, {last.id, keyframe->id});
    odometry->T_1_2 = noisy(robotAt(k_ - 1).inverse() * robotAt(k_), kOdometry_m, kOdometry_rad);
    odometry->setCovariance(isotropicCovariance(kOdometry_m, kOdometry_rad));
    keyframe->T_map_node = last.T_map_node * odometry->T_1_2;
  }
  keyframe->T_map_node_first = keyframe->T_map_node;
  const int nearest =
      kObjectsPerFloor * (k_ % params_.keyframes_per_lap) / params_.keyframes_per_lap;
  for (int i = 0; i + 1 < params_.observations_per_keyframe; ++i) {
    const int index = (nearest + i) % kObjectsPerFloor;
    observe(graph, {floorAt(k_) * kObjectsPerFloor + index}, objectPose(floorAt(k_), index),
            SemanticClass::kObject, keyframe->id, keyframe->T_map_node, delta);
  }
  observe(graph, {kAgent}, agentPose(k_), SemanticClass::kAgent, keyframe->id, keyframe->T_map_node,
          delta);
  if (params_.planes && k_ % 3 == 0) seeStructure(graph, delta, *keyframe);
  const int before = lastVisit(k_);
  if (params_.loop_every > 0 && before >= 0 && k_ % params_.loop_every == 0) {
    const CNodeKeyframe* seen = stillThere(graph, params_, before);
    const Pose3 T_map_seen = robotAt(seen ? static_cast<int>(seen->frame_index) : before);
    // Drawn in any case: the noise of what follows does not depend on who is still there.
    const Pose3 T_seen_here = noisy(T_map_seen.inverse() * robotAt(k_), 0.05, 0.01);
    if (seen) {
      auto loop = addEdge<CEdgeLoopClosure>(graph, delta, {seen->id, keyframe->id});
      loop->T_1_2 = T_seen_here;
      loop->setCovariance(isotropicCovariance(0.05, 0.01));
    }
  }
  ++k_;
  return delta;
}

CSceneGraph generateGraph(const WorldParams& params, int keyframes) {
  GeneratedWorld world(params);
  CSceneGraph graph;
  for (int k = 0; k < keyframes; ++k) graph.apply(world.nextKeyframe(graph));
  return graph;
}

}  // namespace dynemo::test
