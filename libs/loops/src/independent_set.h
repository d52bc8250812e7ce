#pragma once

#include <cstddef>
#include <vector>

namespace dynemo {

/// The set of vertices, no two of them neighbours, with the largest sum of weights (all ≥ 0).
/// Exact by branch and bound; after a fixed number of branches the best set so far, which is at
/// least the greedy one.
std::vector<bool> heaviestIndependentSet(const std::vector<std::vector<std::size_t>>& neighbors,
                                         const std::vector<double>& weights);

}  // namespace dynemo
