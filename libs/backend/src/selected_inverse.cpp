#include "selected_inverse.h"

#include <Eigen/Dense>
#include <algorithm>

namespace dynemo::backend {

SelectedInverse::SelectedInverse(const cholmod_factor& L) : supernode_of_(L.n) {
  const int *super = static_cast<const int*>(L.super), *pi = static_cast<const int*>(L.pi),
            *px = static_cast<const int*>(L.px), *rows = static_cast<const int*>(L.s);
  const double* values = static_cast<const double*>(L.x);
  supernodes_.resize(L.nsuper);
  for (std::size_t s = 0; s < L.nsuper; ++s) {
    Supernode& node = supernodes_[s];
    node.first_column = super[s];
    node.columns = super[s + 1] - super[s];
    node.rows.assign(rows + pi[s], rows + pi[s + 1]);
    std::fill_n(supernode_of_.begin() + node.first_column, node.columns, static_cast<int>(s));
  }
  // From the roots down, so that everything above a supernode is known.
  for (std::size_t s = L.nsuper; s-- > 0;) invert(supernodes_[s], values + px[s]);
}

MatrixX SelectedInverse::gatherBelow(const Supernode& s) const {
  const auto n = static_cast<Eigen::Index>(s.rows.size()) - s.columns;
  const int* R = s.rows.data() + s.columns;
  MatrixX Z(n, n);
  for (Eigen::Index j = 0; j < n;) {
    const Supernode& above = supernodes_[supernode_of_[R[j]]];
    // Columns j … end of R belong to `above`, whose rows include all of R from j on.
    Eigen::Index end = j;
    while (end < n && R[end] < above.first_column + above.columns) ++end;
    auto at = above.rows.begin();
    for (Eigen::Index i = j; i < n; ++i) {
      at = std::lower_bound(at, above.rows.end(), R[i]);
      const auto row = at - above.rows.begin();
      for (Eigen::Index c = j; c < end; ++c) {
        Z(i, c) = Z(c, i) = above.Z(row, R[c] - above.first_column);
      }
    }
    j = end;
  }
  return Z;
}

void SelectedInverse::invert(Supernode& s, const double* values) const {
  const auto height = static_cast<Eigen::Index>(s.rows.size());
  const Eigen::Map<const MatrixX> L(values, height, s.columns);
  const auto L_SS = L.topRows(s.columns).triangularView<Eigen::Lower>();
  s.Z.resize(height, s.columns);
  const MatrixX L_inv = L_SS.solve(MatrixX::Identity(s.columns, s.columns));
  auto Z_SS = s.Z.topRows(s.columns);
  Z_SS.noalias() = L_inv.transpose() * L_inv;
  if (height == s.columns) return;
  const MatrixX Y = L.bottomRows(height - s.columns) * L_inv;
  auto Z_RS = s.Z.bottomRows(height - s.columns);
  Z_RS.noalias() = -gatherBelow(s) * Y;
  Z_SS.noalias() -= Y.transpose() * Z_RS;
}

MatrixX SelectedInverse::diagonalBlock(int first, int size) const {
  MatrixX block(size, size);
  for (int j = 0; j < size; ++j) {
    const Supernode& s = supernodes_[supernode_of_[first + j]];
    for (int i = j; i < size; ++i) {
      const auto at = std::lower_bound(s.rows.begin(), s.rows.end(), first + i) - s.rows.begin();
      block(i, j) = block(j, i) = s.Z(at, first + j - s.first_column);
    }
  }
  return block;
}

}  // namespace dynemo::backend
