#include "dynemo/life/removal.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "information_shares.h"
#include "local_marginal.h"
#include "recovered_edge.h"

namespace dynemo {
namespace {

using namespace life;

/// Rotations of a measurement further than this from the estimates cannot be taken for linear.
constexpr double kMaxShift_rad = 0.3;
/// Relative to the largest eigenvalue, so that an information matrix can be factorised.
constexpr double kLeastEigenvalue = 1e-9;

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

/// The edge that says that the object has not moved since its observation before this one, or null.
const CEdgeIntraEntity* tieToPrevious(const CSceneGraph& graph, const CNodeEntity& seen) {
  if (seen.semantic_class == SemanticClass::kAgent || seen.moved) return nullptr;
  const auto& track = graph.tracks().at(seen.entity);
  const auto here = std::find_if(track.begin(), track.end(),
                                 [&](const auto& node) { return node->id == seen.id; });
  if (here == track.begin() || here == track.end()) return nullptr;
  for (const EdgeId id : graph.edgesOf(seen.id)) {
    const auto* edge = dynamic_cast<const CEdgeIntraEntity*>(graph.edgeSlots()[id.value].get());
    if (edge && edge->nodes[0] == (*std::prev(here))->id && edge->nodes[1] == seen.id &&
        local(Pose3(), edge->T_1_2).isZero())
      return edge;
  }
  return nullptr;
}

/// An unmoved object is where it was: observations tied to the one that leaves are tied to the one
/// before it instead, as firmly as they were. A chain through all that left would get ever looser.
void rehang(const CSceneGraph& graph, NodeId seen, Departure& departure) {
  const CEdgeIntraEntity* tie = tieToPrevious(graph, graph.getNode<CNodeEntity>(seen));
  if (!tie) return;
  for (const EdgeId id : graph.edgesOf(seen)) {
    const auto* edge = dynamic_cast<const CEdgeIntraEntity*>(graph.edgeSlots()[id.value].get());
    if (!edge || edge == tie) continue;
    auto copy = std::dynamic_pointer_cast<CEdgeBase>(edge->duplicateGetSmartPtr());
    std::replace(copy->nodes.begin(), copy->nodes.end(), seen, tie->nodes[0]);
    std::erase(departure.factors, id);
    departure.rehung.emplace_back(id, copy);
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

/// Of two nodes, in nats.
double mutualInformation(const LocalMarginal& marginal, std::size_t a, std::size_t b) {
  const int at_a = marginal.offset(a), n_a = marginal.offset(a + 1) - at_a;
  const int at_b = marginal.offset(b), n_b = marginal.offset(b + 1) - at_b;
  const MatrixX joint = jointBlock(marginal.covariance(), at_a, n_a, at_b, n_b);
  return 0.5 * (logDeterminant(joint.topLeftCorner(n_a, n_a)) +
                logDeterminant(joint.bottomRightCorner(n_b, n_b)) - logDeterminant(joint));
}

/// Two nodes that an edge could tie.
struct Pair {
  std::size_t a, b;
  CEdgeBase::Ptr edge;
  const CEdgeBase* same = nullptr;
  bool in_tree = false, is_odometry = false;
  double mutual_information = 0.0;
};

std::vector<Pair> possiblePairs(const CSceneGraph& graph, const Departure& departure,
                                const LocalMarginal& marginal) {
  std::vector<Pair> pairs;
  const auto& nodes = marginal.nodes();
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (std::size_t b = a + 1; b < nodes.size(); ++b) {
      const auto edge = edgeBetween(graph, departure, *nodes[a], *nodes[b]);
      if (!edge) continue;
      const bool forward = edge->nodes.front() == nodes[a]->id;
      Pair pair{forward ? a : b, forward ? b : a, edge};
      pair.same = sameEdge(graph, *edge);
      if (pair.same) measureLike(*pair.same, *edge);
      pair.is_odometry = dynamic_cast<const CEdgeOdometry*>(edge.get()) != nullptr;
      pair.mutual_information = mutualInformation(marginal, a, b);
      pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

/// The tree of the largest sum (C. Chow and C. Liu, 1968) that holds the odometry.
void markTree(std::vector<Pair>& pairs, std::size_t nodes) {
  std::vector<std::size_t> order(pairs.size()), part(nodes);
  std::iota(order.begin(), order.end(), 0);
  std::iota(part.begin(), part.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
    const Pair &p = pairs[i], &q = pairs[k];
    return p.is_odometry != q.is_odometry ? p.is_odometry
                                          : p.mutual_information > q.mutual_information;
  });
  for (const std::size_t i : order) {
    const std::size_t a = part[pairs[i].a], b = part[pairs[i].b];
    if (a == b) continue;
    std::replace(part.begin(), part.end(), b, a);
    pairs[i].in_tree = true;
  }
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
  m.information = Eigen::LLT<MatrixX>(covariance)
                      .solve(MatrixX::Identity(covariance.rows(), covariance.rows()));
  m.information = 0.5 * (m.information + m.information.transpose()).eval();
  return m;
}

/// Residuals are [translation rotation] of poses, [direction offset] of planes, a height of floors.
bool isWeak(const MatrixX& information, const LifeParams& params) {
  const Eigen::Index n = information.rows(), rotations = n == 6 ? 3 : n == 3 ? 2 : 0;
  const MatrixX covariance = Eigen::LLT<MatrixX>(information).solve(MatrixX::Identity(n, n));
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
    std::vector<bool> used(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      used[i] = pairs_[i].is_odometry || isWorthKeeping(i);
    keepTied(used);
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      if (used[i]) insert(i);
    return std::move(delta_);
  }

 private:
  void choosePairs() {
    pairs_ = possiblePairs(graph_, departure_, marginal_);
    markTree(pairs_, marginal_.nodes().size());
    std::erase_if(pairs_, [](const Pair& p) { return !p.in_tree && !p.same; });
    for (const Pair& pair : pairs_) measured_.push_back(measurementOf(marginal_, pair));
    // Twice what the marginal was given, so that rounding cannot eat it up.
    shares_ = informationShares(marginal_.information(), measured_, 2.0 * kNextToNothing);
    for (const PairMeasurement& m : measured_) {
      VectorX both(m.size_a + m.size_b);
      both << marginal_.mean().segment(m.at_a, m.size_a),
          marginal_.mean().segment(m.at_b, m.size_b);
      shifts_.push_back(m.J * both);
    }
  }

  bool isWorthKeeping(std::size_t i) const {
    return shares_[i] > 0.0 && rotationPart(shifts_[i]) < kMaxShift_rad &&
           !isWeak(shares_[i] * measured_[i].information, params_);
  }

  /// A node that would lose its last edge keeps the best of the tree.
  void keepTied(std::vector<bool>& used) const {
    const auto& nodes = marginal_.nodes();
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const auto& edges = graph_.edgesOf(nodes[node]->id);
      const bool tied = std::any_of(edges.begin(), edges.end(), [&](EdgeId id) {
        return std::find(delta_.removed_edges.begin(), delta_.removed_edges.end(), id) ==
               delta_.removed_edges.end();
      });
      if (tied) continue;
      std::optional<std::size_t> best;
      bool has_one = false;
      for (std::size_t i = 0; i < pairs_.size(); ++i) {
        if (pairs_[i].a != node && pairs_[i].b != node) continue;
        has_one |= used[i];
        if (!best || pairs_[i].mutual_information > pairs_[*best].mutual_information) best = i;
      }
      if (!has_one && best) used[*best] = true;
    }
  }

  void insert(std::size_t i) {
    const Pair& pair = pairs_[i];
    const CEdgeBase::Ptr& edge = pair.edge;
    MatrixX information = std::max(shares_[i], kLeastShare) * measured_[i].information;
    VectorX shift = shifts_[i];
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

  static constexpr double kLeastShare = 0.01;

  const CSceneGraph& graph_;
  const LifeParams& params_;
  Departure departure_;
  LocalMarginal marginal_;
  std::vector<Pair> pairs_;
  std::vector<PairMeasurement> measured_;
  std::vector<double> shares_;
  std::vector<VectorX> shifts_;
  GraphDelta delta_;
};

}  // namespace

GraphDelta removalOf(const CSceneGraph& graph, NodeId keyframe, const LifeParams& params) {
  return Removal(graph, keyframe, params).run();
}

}  // namespace dynemo
