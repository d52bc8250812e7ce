// What the factors of nodes that leave the graph say of the nodes around them.
#pragma once

#include <span>
#include <vector>

#include "dynemo/core/noise.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo::life {

/// The quadratic ½ δᵀ Λ δ + gᵀ δ in the tangents of the surrounding nodes, at the graph's present
/// estimates: the factors, with the weights that their kernels give them there, after the leaving
/// nodes are eliminated. Λ is singular where the factors say nothing, such as where all is.
class LocalMarginal {
 public:
  /// The factors must say where the leaving nodes are, and nothing of where the map's origin is.
  LocalMarginal(const CSceneGraph& graph, std::span<const NodeId> leaving,
                std::span<const EdgeId> factors);

  /// Nodes that stay, ascending by id, and where their tangents begin.
  const std::vector<const CNodeBase*>& nodes() const { return nodes_; }
  int offset(std::size_t node) const { return offset_[node]; }
  int size() const { return offset_.back(); }

  const MatrixX& information() const { return information_; }
  /// (Λ + ε)⁻¹ with an ε that is next to nothing, and the δ of least cost.
  const MatrixX& covariance() const { return covariance_; }
  const VectorX& mean() const { return mean_; }

  /// Derivative of a residual by the tangents of two of the nodes, side by side.
  MatrixX jacobian(const CEdgeBase& edge, std::size_t a, std::size_t b) const;

 private:
  void place(const CSceneGraph& graph, std::span<const NodeId> leaving,
             std::span<const EdgeId> factors);
  void addFactor(const CEdgeBase& edge, MatrixX& H, VectorX& g) const;
  void eliminate(const MatrixX& H, const VectorX& g);
  std::size_t indexOf(NodeId node) const;

  /// Those that stay, then those that leave.
  std::vector<const CNodeBase*> nodes_, all_;
  std::vector<int> offset_, offset_of_all_;
  std::vector<std::vector<double>> states_;  ///< with the origin among the nodes, for the rounding
  std::map<NodeId, std::size_t> index_;
  MatrixX information_, covariance_;
  VectorX mean_;
};

/// ε [1/m², 1/rad²]: a standard deviation of 30 m.
constexpr double kNextToNothing = 1e-3;

}  // namespace dynemo::life
