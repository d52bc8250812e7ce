#include "loop_graph.h"

#include <cmath>

#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo::test {
namespace {

Scan someScan() {
  Scan scan;
  for (int i = 0; i < 40; ++i) {
    const float a = 0.157F * static_cast<float>(i);
    scan.cloud.points.emplace_back(3.0F * std::cos(a), 3.0F * std::sin(a), 0.1F);
  }
  return scan;
}

}  // namespace

LoopGraph::LoopGraph(const LoopGraphParams& params)
    : optimizer(SolverParams{}), params_(params), rng_(params.seed) {}

Pose3 LoopGraph::truth(std::size_t keyframe) const {
  const double lap_m = 2.0 * (params_.length_m + params_.width_m);
  const double at_m =
      std::fmod(static_cast<double>(keyframe) * lap_m / params_.keyframes_per_lap, lap_m);
  const double l = params_.length_m, w = params_.width_m;
  const auto pose = [](double x, double y, double yaw) {
    return Pose3::fromYawPitchRoll(x, y, 0, yaw, 0, 0);
  };
  if (at_m < l) return pose(at_m, 0, 0);
  if (at_m < l + w) return pose(l, at_m - l, M_PI_2);
  if (at_m < 2 * l + w) return pose(2 * l + w - at_m, w, M_PI);
  return pose(0, lap_m - at_m, -M_PI_2);
}

const CNodeKeyframe& LoopGraph::addKeyframe() {
  static const auto scan = std::make_shared<const Scan>(someScan());
  const std::size_t index = graph.keyframes().size();
  auto node = std::make_shared<CNodeKeyframe>();
  node->id = graph.nextNodeId();
  node->stamp = Stamp::fromSeconds(1000.0 + static_cast<double>(index));
  node->scan = scan;
  GraphDelta delta;
  delta.nodes = {node};
  if (index == 0) {
    T_odom_base_ = truth(0);
    auto prior = std::make_shared<CEdgePosePrior>();
    prior->id = graph.nextEdgeId();
    prior->nodes = {node->id};
    prior->T_map_node = T_odom_base_;
    prior->setCovariance(isotropicCovariance(1e-3, 1e-3));
    node->T_map_node = T_odom_base_;
    delta.edges = {prior};
  } else {
    std::normal_distribution<double> noise;
    Vector6 d;
    for (int i = 0; i < 6; ++i) d[i] = noise(rng_) * (i < 3 ? params_.sigma_m : params_.sigma_rad);
    d.segment<3>(2).setZero();  // z, roll and pitch do not drift
    const Pose3 T_last_base = trueRelative(index - 1, index).retract(d);
    T_odom_base_ = T_odom_base_ * T_last_base;
    const CNodeKeyframe& last = *graph.keyframes().back();
    auto edge = std::make_shared<CEdgeOdometry>();
    edge->id = graph.nextEdgeId();
    edge->nodes = {last.id, node->id};
    edge->T_1_2 = T_last_base;
    edge->setCovariance(isotropicCovariance(params_.claimed_scale * params_.sigma_m,
                                            params_.claimed_scale * params_.sigma_rad));
    node->T_map_node = last.T_map_base() * T_last_base;
    delta.edges = {edge};
  }
  node->T_map_node_first = node->T_map_node;
  node->T_odom_base = T_odom_base_;
  graph.apply(delta);
  return *graph.keyframes().back();
}

const CNodeEntity& LoopGraph::see(EntityId entity, const Pose3& T_map_entity,
                                  SemanticClass semantic_class, PointIndices fragment) {
  const CNodeKeyframe& keyframe = *graph.keyframes().back();
  auto node = std::make_shared<CNodeEntity>();
  node->id = graph.nextNodeId();
  node->entity = entity;
  node->semantic_class = semantic_class;
  node->keyframe = keyframe.id;
  node->stamp = keyframe.stamp;
  node->fragment = std::move(fragment);
  auto edge = std::make_shared<CEdgeKeyframeEntity>();
  edge->id = graph.nextEdgeId();
  edge->nodes = {keyframe.id, node->id};
  edge->T_1_2 = truth(graph.keyframes().size() - 1).inverse() * T_map_entity;
  edge->setCovariance(isotropicCovariance(0.01, 0.01));
  node->T_map_node = node->T_map_node_first = keyframe.T_map_base() * edge->T_1_2;
  GraphDelta delta;
  delta.nodes = {node};
  delta.edges = {edge};
  graph.apply(delta);
  return *graph.lastObservation(entity);
}

void LoopGraph::optimize() { optimizer.optimize(graph); }

double LoopGraph::rmse_m() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < graph.keyframes().size(); ++k)
    sum += (graph.keyframes()[k]->T_map_base().t - truth(k).t).squaredNorm();
  return std::sqrt(sum / static_cast<double>(graph.keyframes().size()));
}

}  // namespace dynemo::test
