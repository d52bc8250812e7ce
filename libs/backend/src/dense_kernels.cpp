#include "dense_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

// Every sum runs over the pivots in ascending order: wider registers give the same bits, only
// sooner. Products are fused with sums (see CMakeLists.txt) on processors that can.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define DYNEMO_WIDEST_VECTORS \
  __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define DYNEMO_WIDEST_VECTORS
#endif
#define DYNEMO_INLINE [[gnu::always_inline]] inline

namespace dynemo::backend {
namespace {

/// Pivots whose outer product is subtracted from the rest at once.
constexpr int kBlock = 48;
/// Columns that a tile of registers holds.
constexpr int kTileColumns = 4;
constexpr int kLanes = 8;
using Lanes [[gnu::vector_size(kLanes * sizeof(double)), gnu::aligned(8), gnu::may_alias]] = double;

DYNEMO_INLINE double* at(double* A, int ld, int row, int column) {
  return A + static_cast<std::ptrdiff_t>(column) * ld + row;
}
DYNEMO_INLINE const double* at(const double* A, int ld, int row, int column) {
  return A + static_cast<std::ptrdiff_t>(column) * ld + row;
}
DYNEMO_INLINE Lanes& lanes(double* p) { return *reinterpret_cast<Lanes*>(p); }
DYNEMO_INLINE const Lanes& lanes(const double* p) { return *reinterpret_cast<const Lanes*>(p); }

static_assert(kPaddingRows >= kLanes - 1);

/// C −= P Qᵀ of 8·kRows rows and kColumns columns, held in registers.
template <int kRows, int kColumns>
DYNEMO_INLINE void subtractTile(const double* P, const double* Q, double* C, int ld, int depth) {
  Lanes sum[kRows][kColumns];
#pragma GCC unroll 8
  for (int c = 0; c < kColumns; ++c)
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) sum[r][c] = lanes(at(C, ld, kLanes * r, c));
  for (int k = 0; k < depth; ++k) {
    const double *const p = at(P, ld, 0, k), *const q = at(Q, ld, 0, k);
#pragma GCC unroll 8
    for (int c = 0; c < kColumns; ++c)
#pragma GCC unroll 8
      for (int r = 0; r < kRows; ++r) sum[r][c] -= lanes(p + kLanes * r) * q[c];
  }
#pragma GCC unroll 8
  for (int c = 0; c < kColumns; ++c)
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) lanes(at(C, ld, kLanes * r, c)) = sum[r][c];
}

template <int kColumns>
DYNEMO_INLINE void subtractColumns(const double* P, const double* Q, double* C, int ld, int rows,
                                   int depth) {
  int i = 0;
  for (; i + kLanes < rows; i += 2 * kLanes) subtractTile<2, kColumns>(P + i, Q, C + i, ld, depth);
  if (i < rows) subtractTile<1, kColumns>(P + i, Q, C + i, ld, depth);
}

/// The first `columns` columns of C −= P Pᵀ, `rows` rows, `depth` columns of P; from the diagonal
/// down (and up to three entries above it).
DYNEMO_WIDEST_VECTORS
void subtractSquare(const double* P, double* C, int ld, int rows, int columns, int depth) {
  int j = 0;
  for (; j + kTileColumns <= columns; j += kTileColumns)
    subtractColumns<kTileColumns>(P + j, P + j, at(C, ld, j, j), ld, rows - j, depth);
  for (; j < columns; ++j) subtractColumns<1>(P + j, P + j, at(C, ld, j, j), ld, rows - j, depth);
}

/// A few columns on their own.
DYNEMO_WIDEST_VECTORS
int factorizeColumns(double* A, int ld, int rows, int width) {
  for (int j = 0; j < width; ++j) {
    double* const column = at(A, ld, 0, j);
    for (int k = 0; k < j; ++k) {
      const double* const a = at(A, ld, 0, k);
      const double f = a[j];
      for (int i = j; i < rows; i += kLanes) lanes(column + i) -= lanes(a + i) * f;
    }
    if (!(column[j] > 0.0)) return j;
    const double pivot = std::sqrt(column[j]), inverse = 1.0 / pivot;
    column[j] = pivot;
    for (int i = j + 1; i < rows; i += kLanes) lanes(column + i) *= inverse;
  }
  return -1;
}

/// yₖ −= Σᵢ aₖᵢ xᵢ for kColumns columns a, eight partial sums each.
template <int kColumns>
DYNEMO_INLINE void subtractDots(const double* a, int ld, const double* x, int n, double* y) {
  Lanes partial[kColumns] = {};
  int i = 0;
  for (; i + kLanes <= n; i += kLanes)
#pragma GCC unroll 8
    for (int c = 0; c < kColumns; ++c) partial[c] += lanes(at(a, ld, i, c)) * lanes(x + i);
#pragma GCC unroll 8
  for (int c = 0; c < kColumns; ++c) {
    double sum = 0.0;
    // Said outright: a compiler that takes these products side by side would not fuse them.
    for (int k = i; k < n; ++k) sum = std::fma(*at(a, ld, k, c), x[k], sum);
    for (int l = 0; l < kLanes; ++l) sum += partial[c][l];
    y[c] -= sum;
  }
}

/// kPivots pivots and what they subtract from the rows below, kSides right-hand sides x.
template <int kPivots>
DYNEMO_INLINE void eliminateSides(const double* L, int ld, int rows, double* x) {
  Lanes y[kPivots];
#pragma GCC unroll 8
  for (int j = 0; j < kPivots; ++j) {
    y[j] = lanes(x + kSides * j);
#pragma GCC unroll 8
    for (int k = 0; k < j; ++k) y[j] -= y[k] * *at(L, ld, j, k);
    y[j] /= *at(L, ld, j, j);
    lanes(x + kSides * j) = y[j];
  }
  for (int i = kPivots; i < rows; ++i) {
    Lanes sum = lanes(x + kSides * i);
#pragma GCC unroll 8
    for (int j = 0; j < kPivots; ++j) sum -= y[j] * *at(L, ld, i, j);
    lanes(x + kSides * i) = sum;
  }
}

}  // namespace

int factorizePivots(double* A, int ld, int rows, int pivots) {
  for (int first = 0; first < pivots; first += kBlock) {
    const int width = std::min(kBlock, pivots - first), below = rows - first;
    double* const block = at(A, ld, first, first);
    for (int j = 0; j < width; j += kTileColumns) {
      const int few = std::min(kTileColumns, width - j);
      double* const corner = at(block, ld, j, j);
      subtractSquare(block + j, corner, ld, below - j, few, j);
      if (const int bad = factorizeColumns(corner, ld, below - j, few); bad >= 0)
        return first + j + bad;
    }
    const int rest = below - width;
    if (rest > 0) subtractSquare(block + width, at(block, ld, width, width), ld, rest, rest, width);
  }
  return -1;
}

DYNEMO_WIDEST_VECTORS
void forwardSubstitute(const double* L, int ld, int rows, int pivots, double* x) {
  for (int j = 0; j < pivots; ++j) {
    const double* const column = at(L, ld, 0, j);
    const double y = x[j] /= column[j];
    for (int i = j + 1; i < rows; ++i) x[i] -= y * column[i];
  }
}

static_assert(kSides == kLanes);

DYNEMO_WIDEST_VECTORS
void forwardSubstituteSides(const double* L, int ld, int rows, int pivots, double* x) {
  int j = 0;
  for (; j + kSides <= pivots; j += kSides)
    eliminateSides<kSides>(at(L, ld, j, j), ld, rows - j, x + kSides * j);
  for (; j < pivots; ++j) eliminateSides<1>(at(L, ld, j, j), ld, rows - j, x + kSides * j);
}

DYNEMO_WIDEST_VECTORS
void backSubstitute(const double* L, int ld, int rows, int pivots, const double* x, double* y) {
  // What is known first, in the order of memory.
  const int known = rows - pivots;
  int j = 0;
  for (; j + kTileColumns <= pivots; j += kTileColumns)
    subtractDots<kTileColumns>(at(L, ld, pivots, j), ld, x, known, y + j);
  for (; j < pivots; ++j) subtractDots<1>(at(L, ld, pivots, j), ld, x, known, y + j);
  for (j = pivots - 1; j >= 0; --j) {
    const double* const column = at(L, ld, 0, j);
    subtractDots<1>(column + j + 1, ld, y + j + 1, pivots - j - 1, y + j);
    y[j] /= column[j];
  }
}

}  // namespace dynemo::backend
