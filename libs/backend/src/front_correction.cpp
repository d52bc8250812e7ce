#include <algorithm>

#include "dense_kernels.h"
#include "front_factor.h"

namespace dynemo::backend {

void FrontFactor::forget(const LiveProblem& problem, int variable) {
  const int from = problem.tangentOffset(variable), size = problem.tangentSize(variable);
  if (static_cast<std::size_t>(from + size) > carried_.size()) return;  // was never solved
  std::fill_n(&carried_[from], size, 0.0);
}

void FrontFactor::collectPaths(const LiveProblem& problem, std::span<const int> factors) {
  corrected_.clear();
  paths_.clear();
  is_on_path_.resize(static_cast<std::size_t>(tree_.fronts()), 0);
  carried_up_.resize(static_cast<std::size_t>(tree_.fronts()));
  for (const int factor : factors) {
    const int front = tree_.frontOfFactor(problem, factor);
    corrected_.emplace_back(front, factor);
    for (int f = front; f >= 0 && !is_on_path_[f]; f = tree_.front(f).parent) {
      is_on_path_[f] = 1;
      paths_.push_back(f);
    }
  }
  const auto key = [this](int f) { return tree_.front(f).key; };
  std::sort(paths_.begin(), paths_.end(), [&](int a, int b) { return key(a) < key(b); });
  std::sort(corrected_.begin(), corrected_.end(), [&](const auto& a, const auto& b) {
    return std::pair(key(a.first), a.second) < std::pair(key(b.first), b.second);
  });
}

double FrontFactor::correct(LiveProblem& problem, std::span<const int> factors) {
  collectPaths(problem, factors);
  WhitenedFactor work;
  double decrease = 0.0;
  auto next = corrected_.begin();
  for (const int f : paths_) {
    const Front& front = tree_.front(f);
    placeRows(problem, front);
    x_.assign(static_cast<std::size_t>(front.pivot_size + front.row_size), 0.0);
    for (; next != corrected_.end() && next->first == f; ++next) {
      const Residual& change = problem.correct(next->second, work);
      const auto variables = problem.variablesOf(next->second);
      for (std::size_t i = 0; i < variables.size(); ++i)
        for (int k = 0; k < problem.tangentSize(variables[i]); ++k)
          x_[place_[variables[i]] + k] -= work.J[i].col(k).dot(change);
    }
    decrease += carryUp(problem, f);
  }
  for (const int f : paths_) is_on_path_[f] = 0;
  return decrease;
}

double FrontFactor::carryUp(const LiveProblem& problem, int f) {
  Front& front = tree_.front(f);
  for (int c = front.first_child; c >= 0; c = tree_.front(c).next_sibling) {
    if (!is_on_path_[c]) continue;
    const double* entry = carried_up_[c].data();
    for (const int v : tree_.list(tree_.front(c).rows))
      for (int i = 0; i < problem.tangentSize(v); ++i) x_[place_[v] + i] += *entry++;
  }
  const int p = front.pivot_size, r = front.row_size, n = p + r, ld = n + 1;
  forwardSubstitute(front.panel.data, ld, n, p, x_.data());
  double decrease = 0.0;
  front.half_squared_y = 0.0;
  for (int j = 0; j < p; ++j) {
    double& y = front.panel.data[static_cast<std::size_t>(j) * ld + ld - 1];
    y += x_[j];
    decrease += 0.5 * x_[j] * x_[j];
    front.half_squared_y += 0.5 * y * y;
  }
  carried_up_[f].assign(x_.begin() + p, x_.end());
  // The last entry of every packed column of the update matrix.
  double* side = front.update.data + r;
  for (int j = 0; j < r; ++j, side += r + 1 - j) *side += x_[p + j];
  recompute_[f] = 1;
  return decrease;
}

}  // namespace dynemo::backend
