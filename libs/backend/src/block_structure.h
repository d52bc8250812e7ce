// Sparsity of the normal equations, in elimination order, and where each factor adds to them.
#pragma once

#include <cstddef>
#include <vector>

#include "ordering.h"
#include "problem.h"

namespace dynemo::backend {

/// H is stored as its lower triangle in compressed columns. The columns of one variable share their
/// rows (the variable's own rows first), so each variable is a dense column-major panel whose
/// leading dimension is its height.
class BlockStructure {
 public:
  /// Where JₐᵀΩJᵦ of a factor's a-th and b-th variable (b ≤ a) goes.
  struct Target {
    std::size_t offset;  ///< of the block's first entry in the values
    int stride;          ///< leading dimension of its panel
    enum class Place : std::uint8_t {
      kDirect,      ///< rows of a, columns of b
      kTransposed,  ///< rows of b, columns of a
      kSymmetrized  ///< both are one variable: the block and its transpose
    } place;
  };

  BlockStructure(const Connectivity& connectivity, const Adjacency& adjacency,
                 std::vector<int> order);

  int size() const { return static_cast<int>(column_begin_.size()) - 1; }
  std::size_t nonZeros() const { return rows_.size(); }
  /// First tangent entry of a variable, in elimination order.
  int tangentOffset(int variable) const { return tangent_offset_[variable]; }
  /// The variable that owns a tangent entry in elimination order.
  int variableAt(int tangent_entry) const { return variable_at_[tangent_entry]; }
  const std::vector<int>& order() const { return order_; }

  /// Targets of a factor: (0,0), (1,0), (1,1), (2,0), …
  const Target* targets(int factor) const { return &targets_[target_begin_[factor]]; }
  /// Position of each diagonal entry in the values.
  const std::vector<std::size_t>& diagonal() const { return diagonal_; }

  /// A view for CHOLMOD; `values` may be null.
  cholmod_sparse view(double* values) const;

 private:
  void layOutPanels(const Connectivity& connectivity, const Adjacency& adjacency);
  void planTargets(const Connectivity& connectivity);
  Target targetOf(int a, int b) const;

  std::vector<int> order_, position_;
  std::vector<int> tangent_offset_, variable_at_;
  /// Per position: the positions below it that its panel covers, ascending, with their first row in
  /// the panel.
  std::vector<std::size_t> panel_begin_;
  std::vector<int> panel_positions_, panel_rows_;
  std::vector<int> panel_height_;
  /// CHOLMOD's interface is not const-correct; it only reads them.
  mutable std::vector<int> column_begin_, rows_;
  std::vector<std::size_t> diagonal_, target_begin_;
  std::vector<Target> targets_;
};

}  // namespace dynemo::backend
