#include "dynemo/life/removal.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "connection.h"
#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "local_marginal.h"
#include "object_tie.h"
#include "pair_information.h"
#include "recovered_edge.h"

namespace dynemo {
namespace {

using namespace life;

/// Rotations of a measurement further than this from the estimates cannot be taken for linear.
constexpr double kMaxShift_rad = 0.3;
/// Relative to the largest eigenvalue, so that an information matrix can be factorised.
constexpr double kLeastEigenvalue = 1e-9;
/// More pairs say more, and cost more: of six nodes all, of many a few each.
constexpr std::size_t kPairsPerNode = 3;
/// Squares of the floor over which odometry stays, however vague: what holds the first keyframe,
/// and with it the whole map, would else be forgotten bit by bit.
constexpr double kNeighbourhood = 2.0;
/// Of what is known of a pair; an edge that would say less is left out.
constexpr double kLeastShare = 0.01;

bool isMotion(const CSceneGraph& graph, const CEdgeBase& edge) {
  return std::all_of(edge.nodes.begin(), edge.nodes.end(), [&](NodeId node) {
    const auto* entity = graph.findNode<CNodeEntity>(node);
    return entity && entity->semantic_class == SemanticClass::kAgent;
  });
}

void addEdges(const CSceneGraph& graph, NodeId node, Departure& departure) {
  for (const EdgeId id : graph.edgesOf(node)) {
    const CEdgeBase& edge = *graph.edgeSlots()[id.value];
    if (edge.nodes.size() == 1) throw std::logic_error("a node with a prior must stay");
    (isMotion(graph, edge) ? departure.dropped : departure.factors).push_back(id);
  }
}

void sortUnique(std::vector<EdgeId>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

/// An unmoved object is where it was: observations tied to the one that leaves are tied to the one
/// that it is tied to instead, as firmly as they were. A chain through all that left would get ever
/// looser.
void rehang(const CSceneGraph& graph, NodeId seen, Departure& departure) {
  const CEdgeIntraEntity* tie = tieOf(graph, graph.getNode<CNodeEntity>(seen));
  if (!tie) return;
  for (const EdgeId id : graph.edgesOf(seen)) {
    const auto* edge = dynamic_cast<const CEdgeIntraEntity*>(graph.edgeSlots()[id.value].get());
    if (!edge || std::ranges::count(edge->nodes, tie->nodes[0]) > 0) continue;
    std::erase(departure.factors, id);
    departure.rehung.emplace_back(id, carriedOver(*edge, *tie));
  }
}

Departure departureOf(const CSceneGraph& graph, NodeId keyframe) {
  Departure departure;
  departure.keyframe = graph.getNode<CNodeKeyframe>(keyframe).id;
  departure.nodes = {keyframe};
  addEdges(graph, keyframe, departure);
  for (const EdgeId id : std::vector(departure.factors)) {
    const CEdgeBase& edge = *graph.edgeSlots()[id.value];
    if (const auto* odometry = dynamic_cast<const CEdgeOdometry*>(&edge)) {
      (odometry->nodes[0] == keyframe ? departure.after : departure.before) =
          odometry->nodes[odometry->nodes[0] == keyframe ? 1 : 0];
    }
    const auto* seen = graph.findNode<CNodeEntity>(edge.nodes.back());
    if (!seen || seen->keyframe != keyframe) continue;
    if (std::find(departure.nodes.begin(), departure.nodes.end(), seen->id) ==
        departure.nodes.end())
      departure.nodes.push_back(seen->id);
  }
  for (std::size_t i = 1; i < departure.nodes.size(); ++i)
    addEdges(graph, departure.nodes[i], departure);
  sortUnique(departure.factors);
  sortUnique(departure.dropped);
  for (std::size_t i = 1; i < departure.nodes.size(); ++i)
    rehang(graph, departure.nodes[i], departure);
  return departure;
}

double logDeterminant(const MatrixX& m) {
  return 2.0 * Eigen::LLT<MatrixX>(m).matrixLLT().diagonal().array().log().sum();
}

/// ln|Σ| of every node.
std::vector<double> logDeterminants(const LocalMarginal& marginal) {
  std::vector<double> all;
  for (std::size_t i = 0; i < marginal.nodes().size(); ++i) {
    const int at = marginal.offset(i), n = marginal.offset(i + 1) - at;
    all.push_back(logDeterminant(marginal.covariance().block(at, at, n, n)));
  }
  return all;
}

/// ln|Σ| of two nodes together.
double jointLogDeterminant(const LocalMarginal& marginal, std::size_t a, std::size_t b) {
  const int at_a = marginal.offset(a), n_a = marginal.offset(a + 1) - at_a;
  const int at_b = marginal.offset(b), n_b = marginal.offset(b + 1) - at_b;
  return logDeterminant(jointBlock(marginal.covariance(), at_a, n_a, at_b, n_b));
}

/// Two nodes that an edge could tie.
struct Pair {
  std::size_t a, b;
  CEdgeBase::Ptr edge;
  const CEdgeBase* same = nullptr;
  bool in_tree = false, is_odometry = false;
  /// Odometry that says something, or that ties neighbours.
  bool is_kept = false;
  double mutual_information = 0.0;  ///< in nats
};

std::vector<Pair> possiblePairs(const CSceneGraph& graph, const Departure& departure,
                                const LocalMarginal& marginal) {
  std::vector<Pair> pairs;
  const auto& nodes = marginal.nodes();
  const std::vector<double> alone = logDeterminants(marginal);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (std::size_t b = a + 1; b < nodes.size(); ++b) {
      const auto edge = edgeBetween(graph, departure, *nodes[a], *nodes[b]);
      if (!edge) continue;
      const bool forward = edge->nodes.front() == nodes[a]->id;
      Pair pair{forward ? a : b, forward ? b : a, edge};
      pair.same = sameEdge(graph, *edge);
      if (pair.same) measureLike(*pair.same, *edge);
      pair.is_odometry = dynamic_cast<const CEdgeOdometry*>(edge.get()) != nullptr;
      pair.mutual_information = 0.5 * (alone[a] + alone[b] - jointLogDeterminant(marginal, a, b));
      pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

/// The tree of the largest sum (C. Chow and C. Liu, 1968) that holds the odometry, if that is kept.
void markTree(std::vector<Pair>& pairs, std::size_t nodes) {
  std::vector<std::size_t> order(pairs.size()), part(nodes);
  std::iota(order.begin(), order.end(), 0);
  std::iota(part.begin(), part.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
    const Pair &p = pairs[i], &q = pairs[k];
    return p.is_kept != q.is_kept ? p.is_kept : p.mutual_information > q.mutual_information;
  });
  for (const std::size_t i : order) {
    const std::size_t a = part[pairs[i].a], b = part[pairs[i].b];
    if (a == b) continue;
    std::replace(part.begin(), part.end(), b, a);
    pairs[i].in_tree = true;
  }
}

/// The pairs of the tree, those that have an edge, and of the others those that share the most, so
/// many in all. Ascending.
std::vector<std::size_t> strongest(const std::vector<Pair>& pairs, std::size_t count) {
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), 0);
  const auto rank = [&](std::size_t i) {
    const Pair& p = pairs[i];
    return std::pair(!p.in_tree && !p.same, -p.mutual_information);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t k) { return rank(i) < rank(k); });
  const auto needed = static_cast<std::size_t>(
      std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) { return p.in_tree || p.same; }));
  order.resize(std::min(order.size(), std::max(count, needed)));
  std::sort(order.begin(), order.end());
  return order;
}

PairMeasurement measurementOf(const LocalMarginal& marginal, const Pair& pair) {
  PairMeasurement m;
  m.at_a = marginal.offset(pair.a);
  m.at_b = marginal.offset(pair.b);
  m.size_a = marginal.offset(pair.a + 1) - m.at_a;
  m.size_b = marginal.offset(pair.b + 1) - m.at_b;
  m.J = marginal.jacobian(*pair.edge, pair.a, pair.b);
  const MatrixX joint = jointBlock(marginal.covariance(), m.at_a, m.size_a, m.at_b, m.size_b);
  const MatrixX covariance = m.J * joint * m.J.transpose();
  m.covariance = 0.5 * (covariance + covariance.transpose());
  return m;
}

/// Residuals are [translation rotation] of poses, [direction offset] of planes, a height of floors.
bool isWeak(const MatrixX& covariance, const LifeParams& params) {
  const Eigen::Index n = covariance.rows(), rotations = n == 6 ? 3 : n == 3 ? 2 : 0;
  const auto largest = [&](Eigen::Index at, Eigen::Index size) {
    const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(covariance.block(at, at, size, size),
                                                       Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, eigen.eigenvalues().maxCoeff()));
  };
  const Eigen::Index at_m = n == 3 ? 2 : 0, at_rad = n == 3 ? 0 : 3;
  return largest(at_m, n - rotations) > params.weakest_sigma_m ||
         (rotations > 0 && largest(at_rad, rotations) > params.weakest_sigma_rad);
}

double rotationPart(const VectorX& shift) {
  return shift.size() == 6   ? shift.tail<3>().norm()
         : shift.size() == 3 ? shift.head<2>().norm()
                             : 0;
}

MatrixX conditioned(const MatrixX& information) {
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(information);
  const double least = kLeastEigenvalue * eigen.eigenvalues().maxCoeff();
  return information + std::max(0.0, least - eigen.eigenvalues().minCoeff()) *
                           MatrixX::Identity(information.rows(), information.rows());
}

/// A pair, what is known of it, and where that lies from the estimates.
struct Candidate {
  Pair pair;
  PairMeasurement measured;
  VectorX shift;
};

/// One removal in the making.
class Removal {
 public:
  Removal(const CSceneGraph& graph, NodeId keyframe, const LifeParams& params)
      : graph_(graph),
        params_(params),
        departure_(departureOf(graph, keyframe)),
        marginal_(graph, departure_.nodes, departure_.factors) {}

  GraphDelta run() {
    delta_.removed_edges = departure_.factors;
    delta_.removed_edges.insert(delta_.removed_edges.end(), departure_.dropped.begin(),
                                departure_.dropped.end());
    delta_.removed_nodes = departure_.nodes;
    for (const auto& [id, edge] : departure_.rehung) {
      delta_.removed_edges.push_back(id);
      add(edge);
    }
    choosePairs();
    for (std::size_t i = 0; i < chosen_.size(); ++i) insert(i);
    return std::move(delta_);
  }

 private:
  void choosePairs() {
    std::vector<Pair> possible = possiblePairs(graph_, departure_, marginal_);
    Pair* let_go = nullptr;
    for (Pair& pair : possible) {
      if (!pair.is_odometry) continue;
      pair.is_kept = isBetweenNeighbours(pair) || !isVague(candidateOf(pair));
      if (!pair.is_kept) let_go = &pair;
    }
    markTree(possible, marginal_.nodes().size());
    const std::vector<bool> needed = lastTies(possible);
    for (const std::size_t i : strongest(possible, kPairsPerNode * marginal_.nodes().size())) {
      Candidate candidate = candidateOf(possible[i]);
      if (needed[i] || possible[i].is_kept || !isVague(candidate))
        chosen_.push_back(std::move(candidate));
    }
    if (let_go && !isHeldTogether()) {
      let_go->in_tree = true;
      chosen_.push_back(candidateOf(*let_go));
    }
    std::vector<PairMeasurement> measured;
    for (const Candidate& candidate : chosen_) measured.push_back(candidate.measured);
    information_ = pairInformation(marginal_.size(), measured, kNextToNothing);
  }

  bool isBetweenNeighbours(const Pair& odometry) const {
    const auto at = [&](NodeId id) { return graph_.getNode<CNodeKeyframe>(id).T_map_base().t; };
    const auto& keyframes = odometry.edge->nodes;
    return (at(keyframes[0]) - at(keyframes[1])).norm() < kNeighbourhood * params_.cell_m;
  }

  Candidate candidateOf(const Pair& pair) const {
    Candidate candidate{pair, measurementOf(marginal_, pair), {}};
    const PairMeasurement& m = candidate.measured;
    VectorX both(m.size_a + m.size_b);
    both << marginal_.mean().segment(m.at_a, m.size_a), marginal_.mean().segment(m.at_b, m.size_b);
    candidate.shift = m.J * both;
    return candidate;
  }

  bool isVague(const Candidate& candidate) const {
    return rotationPart(candidate.shift) >= kMaxShift_rad ||
           isWeak(candidate.measured.covariance, params_);
  }

  /// Whether what has been chosen, and what is there, ties the keyframes before and after.
  bool isHeldTogether() const {
    std::vector<std::pair<NodeId, NodeId>> chosen;
    for (const Candidate& candidate : chosen_) {
      const auto* edge = dynamic_cast<const CEdgeRelativePose*>(candidate.pair.edge.get());
      if (edge) chosen.emplace_back(edge->nodes[0], edge->nodes[1]);
    }
    return isConnected(graph_, *departure_.before, *departure_.after,
                       {departure_.nodes.begin(), departure_.nodes.end()}, chosen);
  }

  /// Of a node that would lose its last edge the best pair of the tree.
  std::vector<bool> lastTies(const std::vector<Pair>& pairs) const {
    std::vector<bool> needed(pairs.size(), false);
    const auto& nodes = marginal_.nodes();
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const auto& edges = graph_.edgesOf(nodes[node]->id);
      const bool tied = std::any_of(edges.begin(), edges.end(), [&](EdgeId id) {
        return std::find(delta_.removed_edges.begin(), delta_.removed_edges.end(), id) ==
               delta_.removed_edges.end();
      });
      if (tied) continue;
      std::optional<std::size_t> best;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (!pairs[i].in_tree || (pairs[i].a != node && pairs[i].b != node)) continue;
        if (!best || pairs[i].mutual_information > pairs[*best].mutual_information) best = i;
      }
      if (best) needed[*best] = true;
    }
    return needed;
  }

  void insert(std::size_t i) {
    const auto& [pair, measured, model_shift] = chosen_[i];
    const CEdgeBase::Ptr& edge = pair.edge;
    const MatrixX known = *invertSpd(measured.covariance);
    const double share =
        information_[i].cwiseProduct(measured.covariance).sum() / static_cast<double>(known.rows());
    if (!pair.in_tree && share < kLeastShare) return;
    MatrixX information = information_[i] + kNextToNothing * known;
    VectorX shift = model_shift;
    if (rotationPart(shift) >= kMaxShift_rad) shift.setZero();
    if (pair.same) {
      const VectorX other = -residualOf(*pair.same);
      const MatrixX sum = information + pair.same->information();
      shift = sum.llt().solve(information * shift + pair.same->information() * other);
      information = sum;
      delta_.removed_edges.push_back(pair.same->id);
    }
    if (pair.in_tree) takeSight(graph_, departure_, *edge);
    shiftMeasurement(*edge, shift);
    edge->setInformation(conditioned(information));
    add(edge);
  }

  void add(const CEdgeBase::Ptr& edge) {
    edge->id = {graph_.nextEdgeId().value + delta_.edges.size()};
    delta_.edges.push_back(edge);
  }

  VectorX residualOf(const CEdgeBase& edge) const {
    std::vector<double> a(16), b(16);
    graph_.nodeSlots()[edge.nodes[0].value]->readState(a.data());
    graph_.nodeSlots()[edge.nodes[1].value]->readState(b.data());
    const double* states[] = {a.data(), b.data()};
    Residual e;
    edge.evaluate(states, e, nullptr);
    return e;
  }

  const CSceneGraph& graph_;
  const LifeParams& params_;
  Departure departure_;
  LocalMarginal marginal_;
  std::vector<Candidate> chosen_;
  std::vector<MatrixX> information_;
  GraphDelta delta_;
};

}  // namespace

GraphDelta removalOf(const CSceneGraph& graph, NodeId keyframe, const LifeParams& params) {
  return Removal(graph, keyframe, params).run();
}

}  // namespace dynemo
