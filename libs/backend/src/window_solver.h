// The newest nodes, and those of the map that their edges touch, solved exactly: the rest of the
// map takes part as what it knows about the touched ones, and follows where they go.
#pragma once

#include <span>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "map_follower.h"
#include "map_prior.h"

namespace dynemo::backend {

class WindowSolver {
 public:
  /// A map that holds the edges before `edges` of the graph; it must stay as it is until the next
  /// reset.
  void reset(const IncrementalSolver& map, EdgeId edges);

  /// Solves what is newer than the map and writes it to the graph, as it does the touched nodes and
  /// those of the map that follow them.
  /// False when there is no solution to be had this way; the graph is then as before.
  bool solve(CSceneGraph& graph, OptimizationReport& report);
  /// Nodes that the last solve() wrote.
  std::span<const NodeId> written() const { return written_; }

  /// Of any nodes, new, touched or of the map only; false when there is none. Takes in edges that
  /// have come since the last solve().
  bool covariance(const CSceneGraph& graph, std::span<const NodeId> nodes, MatrixX& joint);

 private:
  bool collect(const CSceneGraph& graph);
  bool takeEdges(const CSceneGraph& graph);
  bool factorize();
  void step();
  double cost() const;
  double priorCost(const VectorX& offset) const;
  bool iterate(OptimizationReport& report);
  void write(CSceneGraph& graph);
  void carryOn(CSceneGraph& graph);
  bool isBehind() const;

  MapPrior prior_;
  MapFollower follower_;
  CholmodContext context_;
  LiveProblem problem_;
  FrontFactor factor_;
  std::size_t edge_count_ = 0;
  EdgeId begin_{}, end_{};  ///< edges that are newer than the map, as far as taken
  /// Of the touched nodes: where they are, and how far from the map's estimate in its tangent.
  std::vector<std::vector<double>> touched_states_;
  VectorX offset_;
  VectorX carried_;  ///< the same where the rest of the map has followed to
  double map_cost_ = 0.0;
  double carried_above_ = 7e-4;  ///< smaller steps are not carried on [m, rad]
  std::vector<double> state_;
  std::vector<NodeId> written_;
};

}  // namespace dynemo::backend
