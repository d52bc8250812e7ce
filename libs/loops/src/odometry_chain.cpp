#include "dynemo/loops/odometry_chain.h"

#include <cmath>

#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

std::optional<PoseEstimate> odometryBetween(const CSceneGraph& graph, NodeId from, NodeId to) {
  for (const EdgeId id : graph.edgesOf(to)) {
    const auto* edge = dynamic_cast<const CEdgeOdometry*>(graph.edgeSlots()[id.value].get());
    if (!edge || edge->nodes[0] != from || edge->nodes[1] != to) continue;
    const auto covariance = invertSpd(MatrixX(edge->information()));
    if (covariance) return PoseEstimate{edge->T_1_2, Matrix6(*covariance)};
  }
  return std::nullopt;
}

}  // namespace

void OdometryChain::extend(const CSceneGraph& graph) {
  const auto& keyframes = graph.keyframes();
  for (std::size_t k = links_.size(); k < keyframes.size(); ++k) {
    Link link;
    if (k > 0) {
      const CNodeKeyframe &before = *keyframes[k - 1], &now = *keyframes[k];
      const Pose3 T_before_now = before.T_odom_base.inverse() * now.T_odom_base;
      link.path_m = links_.back().path_m + T_before_now.t.norm();
      link.previous_this = odometryBetween(graph, before.id, now.id);
    }
    links_.push_back(link);
  }
}

void OdometryChain::remove(std::size_t keyframe) {
  const Link gone = links_.at(keyframe);
  links_.erase(links_.begin() + static_cast<std::ptrdiff_t>(keyframe));
  if (keyframe == links_.size()) return;
  auto& link = links_[keyframe].previous_this;
  link = link && gone.previous_this ? std::optional(compose(*gone.previous_this, *link))
                                    : std::nullopt;
}

double OdometryChain::pathBetween_m(std::size_t a, std::size_t b) const {
  return std::abs(links_[b].path_m - links_[a].path_m);
}

std::optional<PoseEstimate> OdometryChain::between(std::size_t a, std::size_t b,
                                                   double max_sigma_m) const {
  if (a > b) {
    const auto backward = between(b, a, max_sigma_m);
    return backward ? std::optional(inverse(*backward)) : std::nullopt;
  }
  PoseEstimate total;
  for (std::size_t k = a + 1; k <= b; ++k) {
    if (!links_[k].previous_this) return std::nullopt;
    total = compose(total, *links_[k].previous_this);
    if (largestTranslationSigma(total.covariance) > max_sigma_m) return std::nullopt;
  }
  return total;
}

}  // namespace dynemo
