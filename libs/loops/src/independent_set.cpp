#include "independent_set.h"

namespace dynemo {
namespace {

constexpr std::size_t kMaxBranches = 20000;

class Search {
 public:
  Search(const std::vector<std::vector<std::size_t>>& neighbors, const std::vector<double>& weights)
      : neighbors_(neighbors), weights_(weights), best_(weights.size(), false) {}

  std::vector<bool> run() {
    State start;
    start.open.assign(weights_.size(), true);
    start.chosen.assign(weights_.size(), false);
    for (const double weight : weights_) start.open_weight += weight;
    branch(std::move(start));
    return best_;
  }

 private:
  struct State {
    std::vector<bool> open, chosen;  ///< undecided; in the set
    double open_weight = 0.0, weight = 0.0;
  };

  void drop(State& state, std::size_t v) const {
    if (!state.open[v]) return;
    state.open[v] = false;
    state.open_weight -= weights_[v];
  }

  void choose(State& state, std::size_t v) const {
    drop(state, v);
    state.chosen[v] = true;
    state.weight += weights_[v];
    for (const std::size_t u : neighbors_[v]) drop(state, u);
  }

  std::vector<std::size_t> openNeighbors(const State& state, std::size_t v) const {
    std::vector<std::size_t> open;
    for (const std::size_t u : neighbors_[v]) {
      if (state.open[u]) open.push_back(u);
    }
    return open;
  }

  /// Takes what can only be right: vertices without open neighbours, or with a single lighter one.
  /// Returns the open vertex with the most open neighbours, or their number when none is left.
  std::size_t reduce(State& state) const {
    while (true) {
      bool changed = false;
      std::size_t busiest = weights_.size(), most = 0;
      for (std::size_t v = 0; v < weights_.size(); ++v) {
        if (!state.open[v]) continue;
        const auto open = openNeighbors(state, v);
        if (open.empty() || (open.size() == 1 && weights_[v] >= weights_[open[0]])) {
          choose(state, v);
          changed = true;
        } else if (open.size() > most) {
          busiest = v;
          most = open.size();
        }
      }
      if (!changed) return busiest;
    }
  }

  void branch(State state) {
    ++branches_;
    const std::size_t v = reduce(state);
    if (v == weights_.size()) {
      if (state.weight > best_weight_) {
        best_weight_ = state.weight;
        best_ = state.chosen;
      }
      return;
    }
    if (state.weight + state.open_weight <= best_weight_ || branches_ > kMaxBranches) return;
    // Without the vertex of the most conflicts first: this first way down is the greedy one.
    State without = state;
    drop(without, v);
    branch(std::move(without));
    choose(state, v);
    branch(std::move(state));
  }

  const std::vector<std::vector<std::size_t>>& neighbors_;
  const std::vector<double>& weights_;
  std::vector<bool> best_;
  double best_weight_ = -1.0;
  std::size_t branches_ = 0;
};

}  // namespace

std::vector<bool> heaviestIndependentSet(const std::vector<std::vector<std::size_t>>& neighbors,
                                         const std::vector<double>& weights) {
  return Search(neighbors, weights).run();
}

}  // namespace dynemo
