#include "local_marginal.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>
#include <stdexcept>

namespace dynemo::life {
namespace {

/// The state with the map's origin moved to `origin`; tangents of poses do not notice.
std::vector<double> stateFrom(const CNodeBase& node, const Vector3& origin) {
  std::vector<double> state(static_cast<std::size_t>(node.stateSize()));
  node.readState(state.data());
  if (dynamic_cast<const CNodePose*>(&node)) {
    for (std::size_t i = 0; i < 3; ++i) state[i] -= origin[static_cast<Eigen::Index>(i)];
  } else if (const auto* plane = dynamic_cast<const CNodePlane*>(&node)) {
    state.back() += plane->plane_map.normal.dot(origin);
  } else {
    state.back() -= origin.z();  // a floor's level
  }
  return state;
}

}  // namespace

LocalMarginal::LocalMarginal(const CSceneGraph& graph, std::span<const NodeId> leaving,
                             std::span<const EdgeId> factors) {
  place(graph, leaving, factors);
  const Eigen::Index n = offset_of_all_.back();
  MatrixX H = MatrixX::Zero(n, n);
  VectorX g = VectorX::Zero(n);
  for (const EdgeId id : factors) addFactor(*graph.edgeSlots()[id.value], H, g);
  eliminate(H, g);
}

void LocalMarginal::place(const CSceneGraph& graph, std::span<const NodeId> leaving,
                          std::span<const EdgeId> factors) {
  const std::set<NodeId> gone(leaving.begin(), leaving.end());
  std::set<NodeId> staying;
  for (const EdgeId id : factors) {
    for (const NodeId node : graph.edgeSlots()[id.value]->nodes)
      if (!gone.contains(node)) staying.insert(node);
  }
  for (const NodeId id : staying) nodes_.push_back(graph.nodeSlots()[id.value].get());
  all_ = nodes_;
  for (const NodeId id : leaving) all_.push_back(graph.nodeSlots()[id.value].get());
  const Vector3 origin = graph.getNode<CNodeKeyframe>(leaving.front()).T_map_base().t;
  offset_of_all_ = {0};
  for (std::size_t i = 0; i < all_.size(); ++i) {
    index_[all_[i]->id] = i;
    offset_of_all_.push_back(offset_of_all_.back() + all_[i]->tangentSize());
    states_.push_back(stateFrom(*all_[i], origin));
  }
  offset_.assign(offset_of_all_.begin(),
                 offset_of_all_.begin() + static_cast<std::ptrdiff_t>(nodes_.size()) + 1);
}

std::size_t LocalMarginal::indexOf(NodeId node) const { return index_.at(node); }

void LocalMarginal::addFactor(const CEdgeBase& edge, MatrixX& H, VectorX& g) const {
  std::array<const double*, kMaxEdgeNodes> states{};
  for (std::size_t i = 0; i < edge.nodes.size(); ++i)
    states[i] = states_[indexOf(edge.nodes[i])].data();
  Residual e;
  Jacobians J;
  edge.evaluate({states.data(), edge.nodes.size()}, e, &J);
  const VectorX e_white = edge.sqrtInformation() * e;
  const double weight = edge.kernel(e_white.squaredNorm()).weight;
  const MatrixX weighted = weight * edge.information();
  for (std::size_t i = 0; i < edge.nodes.size(); ++i) {
    const int at_i = offset_of_all_[indexOf(edge.nodes[i])];
    const MatrixX JtW = J[i].transpose() * weighted;
    g.segment(at_i, JtW.rows()) += JtW * e;
    for (std::size_t k = 0; k < edge.nodes.size(); ++k) {
      const int at_k = offset_of_all_[indexOf(edge.nodes[k])];
      H.block(at_i, at_k, JtW.rows(), J[k].cols()) += JtW * J[k];
    }
  }
}

void LocalMarginal::eliminate(const MatrixX& H, const VectorX& g) {
  const Eigen::Index n = size(), m = H.rows() - n;
  const MatrixX H_mm = H.bottomRightCorner(m, m) + kNextToNothing * MatrixX::Identity(m, m);
  const Eigen::LLT<MatrixX> leaving(H_mm);
  if (leaving.info() != Eigen::Success)
    throw std::logic_error("nodes to remove are not held by their factors");
  const MatrixX X = leaving.solve(H.bottomLeftCorner(m, n));
  information_ = H.topLeftCorner(n, n) - H.topRightCorner(n, m) * X;
  information_ = 0.5 * (information_ + information_.transpose()).eval();
  const VectorX gradient = g.head(n) - X.transpose() * g.tail(m);
  const Eigen::LLT<MatrixX> marginal(information_ + kNextToNothing * MatrixX::Identity(n, n));
  covariance_ = marginal.solve(MatrixX::Identity(n, n));
  mean_ = -(marginal.solve(gradient));
}

MatrixX LocalMarginal::jacobian(const CEdgeBase& edge, std::size_t a, std::size_t b) const {
  const double* states[] = {states_[a].data(), states_[b].data()};
  Residual e;
  Jacobians J;
  edge.evaluate(states, e, &J);
  MatrixX both(J[0].rows(), J[0].cols() + J[1].cols());
  both << J[0], J[1];
  return both;
}

}  // namespace dynemo::life
