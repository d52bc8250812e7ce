// What a solved map knows about the few of its nodes that newer edges touch.
#pragma once

#include <vector>

#include "front_paths.h"
#include "incremental_solver.h"

namespace dynemo::backend {

/// The marginal of the touched nodes in the tangents at the map's estimates, grown node by node:
/// with Σ = C Cᵀ, each node adds rows to C⁻¹, whose squares add up to the information Σ⁻¹.
class MapPrior {
 public:
  /// The map must stay as it is until the next reset.
  void reset(const IncrementalSolver& map);
  /// Adds a node that the map knows, unless it is in. False when its covariance is not positive
  /// definite.
  bool touch(NodeId node);

  const IncrementalSolver& map() const { return *map_; }
  const std::vector<NodeId>& nodes() const { return nodes_; }
  int size() const { return static_cast<int>(information_.rows()); }
  const MatrixX& information() const { return information_; }
  /// Of the touched nodes with all others held: its excess over information() is what holding them
  /// costs.
  const MatrixX& heldInformation() const { return held_information_; }
  /// Of the touched nodes, in order.
  const std::vector<PathColumns>& columns() const { return columns_; }

  /// Another node of the map: its covariances with the touched ones (rows), and with itself.
  struct Other {
    PathColumns columns;
    MatrixX with_touched;
  };
  Other other(NodeId node);

 private:
  void addHeld(int variable);

  const IncrementalSolver* map_ = nullptr;
  PathTracer tracer_;
  std::vector<NodeId> nodes_;
  std::vector<PathColumns> columns_;
  MatrixX inverse_root_;  ///< C⁻¹
  MatrixX information_, held_information_;
  std::vector<int> offset_;  ///< in the touched tangents, by variable of the map; −1 elsewhere
};

}  // namespace dynemo::backend
