#include "front_tree.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <stdexcept>

#include "ordering.h"

namespace dynemo::backend {
namespace {

/// Positions of variables that stay behind all appended ones.
constexpr int kLastPositions = 1 << 30;
/// More neighbours than this make a variable a hub, when new factors still come to it.
constexpr int kHubDegree = 24;
/// Factors that count as new.
constexpr int kRecentFactors = 64;
/// Variables that share a front when they are appended.
constexpr std::size_t kAppendedPivots = 8;

/// Small fronts are merged up to so many variables, as long as no more than this share of the
/// merged front is zero (cholmod_core.h, nrelax and zrelax).
constexpr std::size_t kMergedColumns[] = {4, 8, 16};
constexpr double kMergedZeros[] = {0.15, 0.05, 0.02};

/// The alive variables, numbered, and their graph.
struct Compact {
  std::vector<int> variables, index;
  Adjacency adjacency;
};

/// Of the variables to keep; the first `clique` ones are coupled.
template <class Keep>
Compact compact(const LiveProblem& problem, int clique, Keep keep) {
  Compact c;
  c.index.assign(static_cast<std::size_t>(problem.variables()), -1);
  Connectivity connectivity;
  for (int v = 0; v < problem.variables(); ++v) {
    if (!problem.alive(v) || !keep(v)) continue;
    c.index[v] = static_cast<int>(c.variables.size());
    c.variables.push_back(v);
    connectivity.tangent_size.push_back(problem.tangentSize(v));
  }
  connectivity.factor_begin.push_back(0);
  for (int f = 0; f < problem.factors(); ++f) {
    for (const int v : problem.variablesOf(f))
      if (c.index[v] >= 0) connectivity.factor_variables.push_back(c.index[v]);
    connectivity.factor_begin.push_back(static_cast<int>(connectivity.factor_variables.size()));
  }
  for (int v = 0; v < clique; ++v)
    if (c.index[v] >= 0) connectivity.factor_variables.push_back(c.index[v]);
  connectivity.factor_begin.push_back(static_cast<int>(connectivity.factor_variables.size()));
  c.adjacency = adjacencyOf(connectivity);
  return c;
}

}  // namespace

Elimination FrontTree::order(const LiveProblem& problem, CholmodContext& context) const {
  std::vector<char> is_hub(static_cast<std::size_t>(problem.variables()), 0);
  for (int f = std::max(0, problem.factors() - kRecentFactors); f < problem.factors(); ++f) {
    for (const int v : problem.variablesOf(f)) is_hub[v] |= problem.degree(v) > kHubDegree;
  }
  std::fill_n(is_hub.begin(), clique_, 1);
  Compact c = compact(problem, clique_, [&](int v) { return !is_hub[v]; });
  Elimination elimination;
  if (!c.variables.empty()) elimination.order = eliminationOrder(c.adjacency, context).order;
  for (int& v : elimination.order) v = c.variables[v];
  for (int v = 0; v < problem.variables(); ++v) {
    if (!is_hub[v] || !problem.alive(v)) continue;
    elimination.order.push_back(v);
    ++elimination.hubs;
  }
  return elimination;
}

void FrontTree::build(const LiveProblem& problem, const Elimination& elimination,
                      CholmodContext& context) {
  const int clique = clique_;
  *this = FrontTree();
  clique_ = clique;
  const auto n = static_cast<std::size_t>(problem.variables());
  front_of_.assign(n, -1);
  position_.assign(n, -1);
  first_owned_.assign(n, -1);
  next_owned_.assign(static_cast<std::size_t>(problem.factors()), -1);
  if (elimination.order.empty()) return;
  layOut(problem, elimination, context);
  for (int f = 0; f < problem.factors(); ++f) {
    if (problem.edge(f)) own(problem, f);
  }
}

void FrontTree::layOut(const LiveProblem& problem, const Elimination& elimination,
                       CholmodContext& context) {
  const std::vector<int>& order = elimination.order;
  // CHOLMOD finds the supernodes of the block pattern, merging small ones.
  Compact c = compact(problem, clique_, [](int) { return true; });
  const int n = static_cast<int>(order.size());
  std::vector<int> permutation;
  for (const int v : order) permutation.push_back(c.index[v]);
  cholmod_sparse pattern =
      lowerTriangleView(n, c.adjacency.begin.data(), c.adjacency.neighbors.data(), nullptr);
  context->nmethods = 1;
  context->method[0].ordering = CHOLMOD_GIVEN;
  context->postorder = 1;
  context->supernodal = CHOLMOD_SUPERNODAL;
  std::copy(std::begin(kMergedColumns), std::end(kMergedColumns), context->nrelax);
  std::copy(std::begin(kMergedZeros), std::end(kMergedZeros), context->zrelax);
  const FactorPtr symbolic(
      cholmod_analyze_p(&pattern, permutation.data(), nullptr, 0, context.get()), {&context});
  if (!symbolic || !symbolic->is_super)
    throw std::runtime_error("out of memory in the symbolic factorisation");
  const int *super = static_cast<const int*>(symbolic->super),
            *pi = static_cast<const int*>(symbolic->pi),
            *rows = static_cast<const int*>(symbolic->s),
            *perm = static_cast<const int*>(symbolic->Perm);
  const auto variable = [&](int k) { return c.variables[perm[k]]; };

  std::vector<char> is_hub(static_cast<std::size_t>(problem.variables()), 0);
  for (std::size_t i = order.size() - elimination.hubs; i < order.size(); ++i) is_hub[order[i]] = 1;
  const int count = static_cast<int>(symbolic->nsuper);
  std::vector<char> last(static_cast<std::size_t>(count), 0);
  std::vector<int> supernode_of(static_cast<std::size_t>(n));
  for (int s = 0; s < count; ++s)
    std::fill(&supernode_of[super[s]], &supernode_of[super[s]] + super[s + 1] - super[s], s);
  int last_position = kLastPositions;
  fronts_.resize(static_cast<std::size_t>(count));
  std::vector<int> values;
  for (int s = 0; s < count; ++s) {
    Front& front = fronts_[s];
    for (int k = super[s]; k < super[s + 1]; ++k) last[s] |= is_hub[variable(k)];
    int& next = last[s] ? last_position : next_position_;
    front.key = next;
    values.clear();
    for (int k = super[s]; k < super[s + 1]; ++k) {
      const int v = variable(k);
      values.push_back(v);
      front_of_[v] = s;
      position_[v] = next++;
      front.pivot_size += problem.tangentSize(v);
    }
    store(front.pivots, values);
    const int below = pi[s] + super[s + 1] - super[s];
    if (below < pi[s + 1]) {
      const int parent = supernode_of[rows[below]];
      setParent(s, parent);
      last[parent] |= last[s];
    }
  }
  for (int s = 0; s < count; ++s) markDirty(s);
}

void FrontTree::append(const LiveProblem& problem, std::span<const int> variables) {
  const auto n = static_cast<std::size_t>(problem.variables());
  front_of_.resize(n, -1);
  position_.resize(n, -1);
  first_owned_.resize(n, -1);
  for (std::size_t first = 0; first < variables.size(); first += kAppendedPivots) {
    const int f = fronts();
    Front& front = fronts_.emplace_back();
    front.key = next_position_;
    const auto pivots =
        variables.subspan(first, std::min(kAppendedPivots, variables.size() - first));
    for (const int v : pivots) {
      front_of_[v] = f;
      position_[v] = next_position_++;
      front.pivot_size += problem.tangentSize(v);
    }
    store(front.pivots, {pivots.begin(), pivots.end()});
    markDirty(f);
  }
}

int FrontTree::ownerOf(const LiveProblem& problem, int factor) const {
  const auto variables = problem.variablesOf(factor);
  return *std::min_element(variables.begin(), variables.end(),
                           [this](int a, int b) { return position_[a] < position_[b]; });
}

void FrontTree::own(const LiveProblem& problem, int factor) {
  const int owner = ownerOf(problem, factor);
  next_owned_[factor] = first_owned_[owner];
  first_owned_[owner] = factor;
}

void FrontTree::addFactor(const LiveProblem& problem, int factor) {
  next_owned_.resize(static_cast<std::size_t>(problem.factors()), -1);
  own(problem, factor);
  touchFactor(problem, factor);
}

void FrontTree::removeFactor(const LiveProblem& problem, int factor) {
  const int owner = ownerOf(problem, factor);
  int* link = &first_owned_[owner];
  while (*link != factor) link = &next_owned_[*link];
  *link = next_owned_[factor];
  touch(owner);
}

void FrontTree::removeVariable(int variable) {
  touch(variable);
  Front& front = fronts_[front_of_[variable]];
  std::vector<int> rest;
  for (const int v : list(front.pivots))
    if (v != variable) rest.push_back(v);
  store(front.pivots, rest);
  front_of_[variable] = -1;
}

void FrontTree::touch(int variable) { markDirty(front_of_[variable]); }

void FrontTree::touchAll() {
  for (int f = 0; f < fronts(); ++f) markDirty(f);
}

void FrontTree::markDirty(int f) {
  if (fronts_[f].dirty) return;
  fronts_[f].dirty = true;
  dirty_.emplace_back(fronts_[f].key, f);
  std::push_heap(dirty_.begin(), dirty_.end(), std::greater<>());
}

void FrontTree::dirtyPaths(std::vector<char>& is_on_path) const {
  is_on_path.assign(fronts_.size(), 0);
  for (const auto& [key, dirty] : dirty_) {
    for (int f = dirty; f >= 0 && !is_on_path[f]; f = fronts_[f].parent) is_on_path[f] = 1;
  }
}

int FrontTree::nextDirty(const LiveProblem& problem) {
  if (dirty_.empty()) return -1;
  std::pop_heap(dirty_.begin(), dirty_.end(), std::greater<>());
  const int f = dirty_.back().second;
  dirty_.pop_back();
  const int old_parent = fronts_[f].parent;
  updateStructure(problem, f);
  if (old_parent >= 0) markDirty(old_parent);
  if (fronts_[f].parent >= 0) markDirty(fronts_[f].parent);
  fronts_[f].dirty = false;
  return f;
}

void FrontTree::updateStructure(const LiveProblem& problem, int f) {
  stamp_.resize(static_cast<std::size_t>(problem.variables()), 0);
  ++current_stamp_;
  rows_.clear();
  Front& front = fronts_[f];
  front.pivot_size = 0;
  for (const int v : list(front.pivots)) {
    stamp_[v] = current_stamp_;
    front.pivot_size += problem.tangentSize(v);
  }
  const auto add = [this](int v) {
    if (stamp_[v] == current_stamp_) return;
    stamp_[v] = current_stamp_;
    rows_.push_back(v);
  };
  for (const int pivot : list(front.pivots)) {
    forEachOwnedFactor(pivot, [&](int factor) {
      for (const int v : problem.variablesOf(factor)) add(v);
    });
    for (int v = 0; pivot < clique_ && v < clique_; ++v)
      if (position_[v] > position_[pivot]) add(v);
  }
  for (int c = front.first_child; c >= 0; c = fronts_[c].next_sibling) {
    for (const int v : list(fronts_[c].rows)) add(v);
  }
  std::sort(rows_.begin(), rows_.end(),
            [this](int a, int b) { return position_[a] < position_[b]; });
  front.row_size = 0;
  for (const int v : rows_) front.row_size += problem.tangentSize(v);
  store(front.rows, rows_);
  setParent(f, rows_.empty() ? -1 : front_of_[rows_.front()]);
}

void FrontTree::setParent(int f, int parent) {
  Front& front = fronts_[f];
  if (front.parent == parent) return;
  if (front.parent >= 0) {
    int* link = &fronts_[front.parent].first_child;
    while (*link != f) link = &fronts_[*link].next_sibling;
    *link = front.next_sibling;
  }
  front.parent = parent;
  front.next_sibling = -1;
  if (parent < 0) return;
  front.next_sibling = fronts_[parent].first_child;
  fronts_[parent].first_child = f;
}

void FrontTree::store(Front::List& l, const std::vector<int>& values) {
  if (static_cast<int>(values.size()) > l.capacity) {
    l.begin = static_cast<int>(pool_.size());
    l.capacity = static_cast<int>(values.size() + values.size() / 2 + 2);
    pool_.resize(pool_.size() + static_cast<std::size_t>(l.capacity));
  }
  l.size = static_cast<int>(values.size());
  std::copy(values.begin(), values.end(), pool_.begin() + l.begin);
}

std::vector<int> FrontTree::ascending() const {
  std::vector<int> all(fronts_.size());
  std::iota(all.begin(), all.end(), 0);
  std::sort(all.begin(), all.end(),
            [this](int a, int b) { return fronts_[a].key < fronts_[b].key; });
  return all;
}

std::vector<int> FrontTree::roots() const {
  std::vector<int> roots;
  for (int f = 0; f < fronts(); ++f)
    if (fronts_[f].parent < 0) roots.push_back(f);
  return roots;
}

double FrontTree::flops() const {
  double sum = 0.0;
  for (const Front& f : fronts_) sum += f.flops();
  return sum;
}

}  // namespace dynemo::backend
