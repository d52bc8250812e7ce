#include "dynemo/loops/candidate_search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "dynemo/mapping/delta_builder.h"

namespace dynemo {

const char* loopOriginName(LoopOrigin origin) {
  switch (origin) {
    case LoopOrigin::kDistance:
      return "distance";
    case LoopOrigin::kUncertainty:
      return "uncertainty";
    case LoopOrigin::kEntities:
      return "entities";
  }
  return "";
}

Expected<std::vector<PoseEstimate>, std::string> relativeEstimates(
    const CSceneGraph& graph, Optimizer& optimizer, const CNodeKeyframe& keyframe,
    const std::vector<const CNodeKeyframe*>& others) {
  std::vector<NodeId> nodes = {keyframe.id};
  for (const CNodeKeyframe* other : others) nodes.push_back(other->id);
  const auto joint = optimizer.marginalCovariance(graph, nodes);
  if (!joint) return make_unexpected(joint.error());
  std::vector<PoseEstimate> estimates;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * (i + 1));
    MatrixX pair(12, 12);
    pair << joint->block<6, 6>(at, at), joint->block<6, 6>(at, 0), joint->block<6, 6>(0, at),
        joint->block<6, 6>(0, 0);
    const Pose3 &T_map_other = others[i]->T_map_base(), &T_map_base = keyframe.T_map_base();
    estimates.push_back({T_map_other.inverse() * T_map_base,
                         relativePoseCovariance(T_map_other, T_map_base, pair)});
  }
  return estimates;
}

/// One search.
class CandidateSearch::Query {
 public:
  Query(const CandidateSearch& search, const CSceneGraph& graph, const OdometryChain& chain)
      : params_(search.params_),
        entities_(search.entities_),
        graph_(graph),
        chain_(chain),
        later_(graph.keyframes().size() - 1),
        newest_(*graph.keyframes().back()) {}

  bool tooSoonAfter(std::size_t closure) const {
    const double since_s = secondsBetween(graph_.keyframes()[closure]->stamp, newest_.stamp);
    return chain_.pathBetween_m(closure, later_) < params_.spacing_m || since_s < params_.spacing_s;
  }

  void addNear(Optimizer& optimizer) {
    const bool uncertain = params_.gate == CandidateGate::kUncertainty;
    const double radius_m = uncertain
                                ? std::max(params_.max_distance_m, params_.max_uncertain_distance_m)
                                : params_.max_distance_m;
    std::vector<LoopCandidate> near;
    for (std::size_t k = 0; k < later_; ++k) {
      if (!comparable(k)) continue;
      const double distance_m = horizontal(graph_.keyframes()[k]->T_map_base());
      if (distance_m <= radius_m) near.push_back(candidate(k, LoopOrigin::kDistance, distance_m));
    }
    std::stable_sort(near.begin(), near.end(),
                     [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
    if (uncertain) {
      // A marginal covariance is dear: as many as may be needed, of different places.
      near = apart(near, 4 * static_cast<std::size_t>(params_.max_candidates));
      near = withinUncertainty(near, optimizer);
    }
    for (const LoopCandidate& c : apart(near, static_cast<std::size_t>(params_.max_candidates)))
      found_.push_back(c);
  }

  /// Keyframes that see the same objects, where these put the two within the radius.
  void addFromEntities() {
    std::map<std::size_t, std::size_t> shared_objects;
    for (const auto& [entity, view] : entitiesSeenFrom(graph_, newest_)) {
      if (view.node->semantic_class != SemanticClass::kObject) continue;
      for (const auto& node : graph_.tracks().at(entity)) {
        const auto keyframe = indexOf(node->keyframe);
        if (keyframe && *keyframe < later_) ++shared_objects[*keyframe];
      }
    }
    std::vector<LoopCandidate> seen;
    for (const auto& [k, count] : shared_objects) {
      if (count < static_cast<std::size_t>(entities_.min_shared) || !comparable(k)) continue;
      const CNodeKeyframe& earlier = *graph_.keyframes()[k];
      const auto consensus = findConsensus(sharedEntities(graph_, earlier, newest_), entities_);
      if (!consensus || !locatesWell(*consensus)) continue;
      const double told_m = consensus->earlier_later.T.t.head<2>().norm();
      if (told_m <= params_.max_distance_m)
        seen.push_back(candidate(k, LoopOrigin::kEntities, told_m));
    }
    std::stable_sort(seen.begin(), seen.end(),
                     [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
    for (LoopCandidate c : seen) {
      if (found_.size() >= static_cast<std::size_t>(params_.max_candidates)) return;
      if (!isApart(c, found_)) continue;
      c.distance_m = horizontal(graph_.keyframes()[c.earlier]->T_map_base());
      found_.push_back(c);
    }
  }

  std::vector<LoopCandidate> take() { return std::move(found_); }

 private:
  bool comparable(std::size_t k) const {
    const CNodeKeyframe& other = *graph_.keyframes()[k];
    const bool same_floor = !other.floor || !newest_.floor || *other.floor == *newest_.floor;
    const double height_m = std::abs(other.T_map_base().t.z() - newest_.T_map_base().t.z());
    return other.scan && same_floor && height_m <= params_.max_height_m &&
           chain_.pathBetween_m(k, later_) >= params_.min_path_m;
  }

  double horizontal(const Pose3& T_map_other) const {
    return (T_map_other.t - newest_.T_map_base().t).head<2>().norm();
  }

  LoopCandidate candidate(std::size_t k, LoopOrigin origin, double distance_m) const {
    return {k, later_, origin, distance_m, chain_.pathBetween_m(k, later_)};
  }

  bool locatesWell(const EntityConsensus& consensus) const {
    return largestTranslationSigma(consensus.earlier_later.covariance) <=
           entities_.max_seed_sigma_m;
  }

  bool isApart(const LoopCandidate& c, const std::vector<LoopCandidate>& others) const {
    return std::all_of(others.begin(), others.end(), [&](const LoopCandidate& other) {
      return c.earlier != other.earlier &&
             chain_.pathBetween_m(c.earlier, other.earlier) >= params_.separation_m;
    });
  }

  std::vector<LoopCandidate> apart(const std::vector<LoopCandidate>& all, std::size_t most) const {
    std::vector<LoopCandidate> chosen;
    for (const LoopCandidate& c : all) {
      if (chosen.size() >= most) break;
      if (isApart(c, chosen)) chosen.push_back(c);
    }
    return chosen;
  }

  /// Those whose distance exceeds the radius by no more than their uncertainty.
  std::vector<LoopCandidate> withinUncertainty(const std::vector<LoopCandidate>& all,
                                               Optimizer& optimizer) const {
    std::vector<const CNodeKeyframe*> others;
    for (const LoopCandidate& c : all) others.push_back(graph_.keyframes()[c.earlier].get());
    const auto estimates = relativeEstimates(graph_, optimizer, newest_, others);
    std::vector<LoopCandidate> chosen;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double growth_m =
          estimates ? params_.uncertainty_sigmas * horizontalSigma((*estimates)[i].covariance)
                    : 0.0;
      if (all[i].distance_m > params_.max_distance_m + growth_m) continue;
      chosen.push_back(all[i]);
      if (all[i].distance_m > params_.max_distance_m)
        chosen.back().origin = LoopOrigin::kUncertainty;
    }
    return chosen;
  }

  static double horizontalSigma(const Matrix6& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance.topLeftCorner<2, 2>(),
                                                               Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, eigen.eigenvalues().maxCoeff()));
  }

  std::optional<std::size_t> indexOf(NodeId keyframe) const {
    const auto& all = graph_.keyframes();
    const auto it = std::lower_bound(all.begin(), all.end(), keyframe,
                                     [](const auto& k, NodeId id) { return k->id < id; });
    if (it == all.end() || (*it)->id != keyframe) return std::nullopt;
    return static_cast<std::size_t>(it - all.begin());
  }

  const CandidateParams& params_;
  const EntityEvidenceParams& entities_;
  const CSceneGraph& graph_;
  const OdometryChain& chain_;
  std::size_t later_;
  const CNodeKeyframe& newest_;
  std::vector<LoopCandidate> found_;
};

std::vector<LoopCandidate> CandidateSearch::search(const CSceneGraph& graph,
                                                   const OdometryChain& chain,
                                                   std::optional<std::size_t> last_closure,
                                                   Optimizer& optimizer) const {
  if (graph.keyframes().size() < 2 || !graph.keyframes().back()->scan) return {};
  Query query(*this, graph, chain);
  if (last_closure && query.tooSoonAfter(*last_closure)) return {};
  query.addNear(optimizer);
  if (entities_.candidates) query.addFromEntities();
  return query.take();
}

}  // namespace dynemo
