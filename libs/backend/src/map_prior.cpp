#include "map_prior.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>

namespace dynemo::backend {

void MapPrior::reset(const IncrementalSolver& map) {
  map_ = &map;
  nodes_.clear();
  columns_.clear();
  inverse_root_.resize(0, 0);
  information_.resize(0, 0);
  held_information_.resize(0, 0);
  offset_.assign(static_cast<std::size_t>(map.problem().variables()), -1);
}

MapPrior::Other MapPrior::other(NodeId node) {
  const LiveProblem& problem = map_->problem();
  Other other;
  const int v = problem.variableOf(node);
  other.columns = tracer_.trace(problem, map_->factor().tree(), v);
  other.with_touched.resize(size(), problem.tangentSize(v));
  Eigen::Index at = 0;
  for (const PathColumns& touched : columns_) {
    const MatrixX block = covariance(touched, other.columns);
    other.with_touched.middleRows(at, block.rows()) = block;
    at += block.rows();
  }
  return other;
}

void MapPrior::addHeld(int variable) {
  const LiveProblem& problem = map_->problem();
  held_information_.conservativeResizeLike(MatrixX::Zero(size(), size()));
  std::array<const double*, kMaxEdgeNodes> states{};
  WhitenedFactor work;
  problem.forEachFactorOf(variable, [&](int f) {
    const auto variables = problem.variablesOf(f);
    for (std::size_t i = 0; i < variables.size(); ++i) states[i] = problem.estimate(variables[i]);
    whitenedFactor(*problem.edge(f), {states.data(), variables.size()}, work);
    for (std::size_t a = 0; a < variables.size(); ++a) {
      for (std::size_t b = 0; b < variables.size(); ++b) {
        const int i = offset_[variables[a]], j = offset_[variables[b]];
        if (i < 0 || j < 0 || (variables[a] != variable && variables[b] != variable)) continue;
        held_information_.block(i, j, work.J[a].cols(), work.J[b].cols()).noalias() +=
            work.J[a].transpose() * work.J[b];
      }
    }
  });
}

bool MapPrior::touch(NodeId node) {
  if (std::find(nodes_.begin(), nodes_.end(), node) != nodes_.end()) return true;
  Other added = other(node);
  const MatrixX own = covariance(added.columns, added.columns);
  const Eigen::Index before = size(), n = own.rows();
  const MatrixX W = inverse_root_ * added.with_touched;
  const Eigen::LLT<MatrixX> rest(own - W.transpose() * W);
  if (rest.info() != Eigen::Success) return false;
  MatrixX rows(n, before + n);
  rows.leftCols(before) = -W.transpose() * inverse_root_;
  rows.rightCols(n).setIdentity();
  rest.matrixL().solveInPlace(rows);
  if (!rows.allFinite()) return false;
  inverse_root_.conservativeResizeLike(MatrixX::Zero(before + n, before + n));
  inverse_root_.bottomRows(n) = rows;
  information_.conservativeResizeLike(MatrixX::Zero(before + n, before + n));
  information_.noalias() += rows.transpose() * rows;
  const int v = map_->problem().variableOf(node);
  offset_[v] = static_cast<int>(before);
  addHeld(v);
  nodes_.push_back(node);
  columns_.push_back(std::move(added.columns));
  return true;
}

}  // namespace dynemo::backend
