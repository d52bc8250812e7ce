#include "ordering.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace dynemo::backend {
namespace {

/// Below it minimum degree gives as little fill, in less time.
constexpr int kNestedDissectionFrom = 1000;

std::vector<int> countsToOffsets(std::vector<int> counts) {
  std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), 0);
  return counts;
}

/// Sorts each list and drops its duplicates.
void makeUnique(Adjacency& a) {
  int write = 0;
  for (std::size_t v = 0; v + 1 < a.begin.size(); ++v) {
    const auto first = a.neighbors.begin() + a.begin[v],
               last = a.neighbors.begin() + a.begin[v + 1];
    std::sort(first, last);
    const auto end = std::unique(first, last);
    std::copy(first, end, a.neighbors.begin() + write);
    a.begin[v] = write;
    write += static_cast<int>(end - first);
  }
  a.begin.back() = write;
  a.neighbors.resize(static_cast<std::size_t>(write));
}

template <class Visit>
void forEachPair(const Connectivity& c, Visit visit) {
  for (int v = 0; v < c.variables(); ++v) visit(v, v);
  for (int f = 0; f < c.factors(); ++f) {
    const auto variables = c.variablesOf(f);
    for (std::size_t a = 0; a < variables.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        if (variables[a] == variables[b]) continue;
        visit(std::min(variables[a], variables[b]), std::max(variables[a], variables[b]));
      }
  }
}

}  // namespace

Adjacency adjacencyOf(const Connectivity& connectivity) {
  std::vector<int> counts(connectivity.tangent_size.size() + 1, 0);
  forEachPair(connectivity, [&](int low, int) { ++counts[low]; });
  Adjacency a;
  a.begin = countsToOffsets(std::move(counts));
  a.neighbors.resize(static_cast<std::size_t>(a.begin.back()));
  std::vector<int> next = a.begin;
  forEachPair(connectivity, [&](int low, int high) { a.neighbors[next[low]++] = high; });
  makeUnique(a);
  return a;
}

namespace {

EliminationOrder analyze(Adjacency& adjacency, int method, std::vector<int>* given,
                         CholmodContext& context) {
  const int n = static_cast<int>(adjacency.begin.size()) - 1;
  cholmod_sparse pattern =
      lowerTriangleView(n, adjacency.begin.data(), adjacency.neighbors.data(), nullptr);
  context->nmethods = 1;
  context->method[0].ordering = method;
  context->postorder = 1;
  context->supernodal = CHOLMOD_SIMPLICIAL;
  const FactorPtr symbolic(
      cholmod_analyze_p(&pattern, given ? given->data() : nullptr, nullptr, 0, context.get()),
      {&context});
  if (!symbolic) throw std::runtime_error("the elimination order could not be computed");
  const int* permutation = static_cast<const int*>(symbolic->Perm);
  return {{permutation, permutation + n}, context->fl};
}

/// The kept order is good for this much more work than a fresh one, and for this much growth.
constexpr double kTolerableFlops = 1.3;
constexpr double kTolerableGrowth = 1.25;

}  // namespace

EliminationOrder eliminationOrder(Adjacency& adjacency, CholmodContext& context) {
  const int n = static_cast<int>(adjacency.begin.size()) - 1;
  return analyze(adjacency, n < kNestedDissectionFrom ? CHOLMOD_AMD : CHOLMOD_METIS, nullptr,
                 context);
}

EliminationOrder postOrdered(Adjacency& adjacency, std::vector<int> order,
                             CholmodContext& context) {
  return analyze(adjacency, CHOLMOD_GIVEN, &order, context);
}

EliminationOrder KeptOrder::update(const Problem& problem, Adjacency& adjacency,
                                   CholmodContext& context) {
  const auto n = static_cast<double>(problem.connectivity().variables());
  const double growth = n / static_cast<double>(renewed_at_variables_);
  if (!(growth < kTolerableGrowth)) return renew(problem, adjacency, context);
  EliminationOrder order = postOrdered(adjacency, extended(problem), context);
  // Fresh orders of planar-like graphs cost n^(3/2).
  const double fresh_flops = renewed_at_flops_ * std::pow(growth, 1.5);
  if (order.flops > kTolerableFlops * fresh_flops) return renew(problem, adjacency, context);
  keep(problem, order.order);
  return order;
}

std::vector<int> KeptOrder::extended(const Problem& problem) const {
  std::vector<char> placed(problem.connectivity().tangent_size.size(), 0);
  std::vector<int> order;
  order.reserve(placed.size());
  for (const NodeId node : nodes_) {
    const int v = problem.variableOf(node);
    if (v < 0) continue;
    placed[v] = 1;
    order.push_back(v);
  }
  for (int v = 0; v < problem.connectivity().variables(); ++v) {
    if (!placed[v]) order.push_back(v);
  }
  return order;
}

EliminationOrder KeptOrder::renew(const Problem& problem, Adjacency& adjacency,
                                  CholmodContext& context) {
  EliminationOrder order = eliminationOrder(adjacency, context);
  renewed_at_variables_ = order.order.size();
  renewed_at_flops_ = order.flops;
  keep(problem, order.order);
  return order;
}

void KeptOrder::keep(const Problem& problem, const std::vector<int>& order) {
  nodes_.clear();
  for (const int v : order) nodes_.push_back(problem.node(v).id);
}

}  // namespace dynemo::backend
