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

/// order[k] is the variable eliminated k-th. Minimum degree on small problems, nested dissection on
/// larger ones, in a post-order of the elimination tree.
std::vector<int> eliminationOrder(Adjacency& adjacency, CholmodContext& context);

}  // namespace dynemo::backend
