#include "map_follower.h"

#include <algorithm>
#include <cmath>

#include "dense_kernels.h"

namespace dynemo::backend {

void MapFollower::reset(const IncrementalSolver& map) {
  map_ = &map;
  const LiveProblem& problem = map.problem();
  step_.assign(static_cast<std::size_t>(problem.tangentSize()), 0.0);
  returned_ = step_;
  neglected_.assign(static_cast<std::size_t>(problem.variables()), 0.0);
  neglected_cost_ = 0.0;
  moved_.assign(static_cast<std::size_t>(problem.variables()), 0);
  right_hand_.assign(static_cast<std::size_t>(map.factor().tree().fronts()), VectorX());
  paths_.clear();
}

const double* MapFollower::step(int variable) const {
  return &step_[map_->problem().tangentOffset(variable)];
}

void MapFollower::gather(const std::vector<PathColumns>& columns, const VectorX& weights) {
  for (const int f : paths_) right_hand_[f].setZero();
  Eigen::Index at = 0;
  for (const PathColumns& node : columns) {
    const Eigen::Index size = node.parts.front().cols();
    for (std::size_t i = 0; i < node.fronts.size(); ++i) {
      const int f = node.fronts[i];
      if (right_hand_[f].size() == 0) {
        right_hand_[f] = VectorX::Zero(node.parts[i].rows());
        paths_.push_back(f);
      }
      right_hand_[f].noalias() += node.parts[i] * weights.segment(at, size);
    }
    at += size;
  }
}

bool MapFollower::anyMoved(const Front::List& l) const {
  const auto list = map_->factor().tree().list(l);
  return std::any_of(list.begin(), list.end(), [this](int v) { return moved_[v] != 0; });
}

void MapFollower::solveFront(int f, double tolerance) {
  const LiveProblem& problem = map_->problem();
  const FrontTree& tree = map_->factor().tree();
  const Front& front = tree.front(f);
  const int p = front.pivot_size, n = p + front.row_size;
  x_.resize(n + 1);
  y_.setZero(p);
  if (right_hand_[f].size() > 0) y_ = right_hand_[f];
  int at = 0;
  for (const int v : tree.list(front.rows)) {
    std::copy_n(step(v), problem.tangentSize(v), &x_[at]);
    at += problem.tangentSize(v);
  }
  backSubstitute(front.panel.data, n + 1, n, p, x_.data(), y_.data());
  at = 0;
  for (const int v : tree.list(front.pivots)) {
    const int from = problem.tangentOffset(v);
    double distance = 0.0, cost = 0.0;
    for (int i = from; i < from + problem.tangentSize(v); ++i, ++at) {
      step_[i] = y_[at];
      const double rest = step_[i] - returned_[i];
      distance = std::max(distance, std::abs(rest));
      // The diagonal of L has the inverse deviation, given what is eliminated later.
      const double deviations = rest * front.panel.data[static_cast<std::size_t>(at) * (n + 2)];
      cost += 0.5 * deviations * deviations;
    }
    const bool neglected = !(distance > tolerance);
    neglected_cost_ -= neglected_[v];
    neglected_[v] = neglected ? cost : 0.0;
    neglected_cost_ += neglected_[v];
    if (neglected) continue;
    std::copy_n(&step_[from], problem.tangentSize(v), &returned_[from]);
    moved_[v] = 1;
    changed_.push_back(v);
  }
}

const std::vector<int>& MapFollower::follow(const std::vector<PathColumns>& columns,
                                            const VectorX& weights, double tolerance) {
  const FrontTree& tree = map_->factor().tree();
  gather(columns, weights);
  changed_.clear();
  stack_.clear();
  for (const int f : paths_)
    if (tree.front(f).parent < 0) stack_.push_back(f);
  while (!stack_.empty()) {
    const int f = stack_.back();
    stack_.pop_back();
    const Front& front = tree.front(f);
    const bool solved = right_hand_[f].size() > 0 || anyMoved(front.rows);
    if (solved) solveFront(f, tolerance);
    if (!solved && !anyMoved(front.pivots)) continue;
    for (int c = front.first_child; c >= 0; c = tree.front(c).next_sibling) {
      if (right_hand_[c].size() > 0 || anyMoved(tree.front(c).rows)) prefetchPanel(tree.front(c));
      stack_.push_back(c);
    }
  }
  for (const int v : changed_) moved_[v] = 0;
  return changed_;
}

}  // namespace dynemo::backend
