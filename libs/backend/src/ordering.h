// The order in which the variables are eliminated.
#pragma once

#include <vector>

#include "cholmod_context.h"
#include "problem.h"

namespace dynemo::backend {

/// The variables as a graph: variable i > j is listed under j when some factor connects them; each
/// variable is listed under itself.
struct Adjacency {
  std::vector<int> begin, neighbors;
};
Adjacency adjacencyOf(const Connectivity& connectivity);

/// order[k] is the variable eliminated k-th, in a post-order of the elimination tree.
struct EliminationOrder {
  std::vector<int> order;
  double flops = 0.0;  ///< of the factorisation, each variable counted as one row
};

/// Minimum degree on small problems, nested dissection on larger ones.
EliminationOrder eliminationOrder(Adjacency& adjacency, CholmodContext& context);
/// A post-order of the given order: the same fill.
EliminationOrder postOrdered(Adjacency& adjacency, std::vector<int> order, CholmodContext& context);

/// Keeps the elimination order of a graph that grows: nodes that it does not know go to the end.
/// Computed anew when the fill outgrows it (a loop closure, a corner of the map that is revisited)
/// or the graph has become a good deal larger.
class KeptOrder {
 public:
  EliminationOrder update(const Problem& problem, Adjacency& adjacency, CholmodContext& context);

 private:
  std::vector<int> extended(const Problem& problem) const;
  EliminationOrder renew(const Problem& problem, Adjacency& adjacency, CholmodContext& context);
  void keep(const Problem& problem, const std::vector<int>& order);

  std::vector<NodeId> nodes_;
  std::size_t renewed_at_variables_ = 0;
  double renewed_at_flops_ = 0.0;
};

}  // namespace dynemo::backend
