// Entries of H⁻¹ on the sparsity of its Cholesky factor, without computing the rest.
//
// For a supernode with columns S and rows R below, L = [L_SS; L_RS] and Y = L_RS L_SS⁻¹ give
//   Z_RS = −Z_RR Y,   Z_SS = L_SS⁻ᵀ L_SS⁻¹ − Yᵀ Z_RS,
// and Z_RR is on the factor's sparsity again, in supernodes further up (Takahashi, Fagan and Chin
// 1973; Erisman and Tinney 1975).
#pragma once

#include <cholmod.h>

#include <vector>

#include "dynemo/core/noise.h"

namespace dynemo::backend {

class SelectedInverse {
 public:
  /// The factor must be supernodal, numeric and LLᵀ; it is not needed afterwards.
  explicit SelectedInverse(const cholmod_factor& L);

  /// The symmetric block of rows and columns [first, first + size), which must be on the factor's
  /// sparsity (a variable's own entries are).
  MatrixX diagonalBlock(int first, int size) const;

 private:
  struct Supernode {
    int first_column, columns;
    std::vector<int> rows;  ///< ascending; begins with the supernode's own columns
    MatrixX Z;              ///< rows.size() × columns; the square part on top is symmetric
  };

  MatrixX gatherBelow(const Supernode& s) const;
  void invert(Supernode& s, const double* values) const;

  std::vector<Supernode> supernodes_;
  std::vector<int> supernode_of_;
};

}  // namespace dynemo::backend
