#include "dense_kernels.h"

#include <cblas.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

// The loops below are axpy loops: wider registers give the same bits, only sooner.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__SANITIZE_ADDRESS__)
#define DYNEMO_WIDEST_VECTORS __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define DYNEMO_WIDEST_VECTORS
#endif

namespace dynemo::backend {
namespace {

/// Pivots that are factorised at once; the BLAS does what is right of them and below.
constexpr int kBlock = 48;
/// Fronts of fewer rows stay off the BLAS, whose calls cost more than they do.
constexpr int kSmallFront = 36;

/// Columns [0, width) of the trapezoid, left-looking.
DYNEMO_WIDEST_VECTORS
int factorizeColumns(double* A, int ld, int rows, int width) {
  for (int j = 0; j < width; ++j) {
    double* const column = A + static_cast<std::ptrdiff_t>(j) * ld;
    int k = 0;
    for (; k + 3 < j; k += 4) {
      const double* const a = A + static_cast<std::ptrdiff_t>(k) * ld;
      const double *const b = a + ld, *const c = b + ld, *const d = c + ld;
      const double fa = a[j], fb = b[j], fc = c[j], fd = d[j];
      for (int i = j; i < rows; ++i) column[i] -= fa * a[i] + fb * b[i] + fc * c[i] + fd * d[i];
    }
    for (; k < j; ++k) {
      const double* const a = A + static_cast<std::ptrdiff_t>(k) * ld;
      const double fa = a[j];
      for (int i = j; i < rows; ++i) column[i] -= fa * a[i];
    }
    if (!(column[j] > 0.0)) return j;
    const double pivot = std::sqrt(column[j]), inverse = 1.0 / pivot;
    column[j] = pivot;
    for (int i = j + 1; i < rows; ++i) column[i] *= inverse;
  }
  return -1;
}

/// trailing (lower triangle of size n) −= panel · panelᵀ.
DYNEMO_WIDEST_VECTORS
void subtractSmall(const double* panel, double* trailing, int ld, int n, int width) {
  for (int j = 0; j < n; ++j) {
    double* const column = trailing + static_cast<std::ptrdiff_t>(j) * ld;
    for (int k = 0; k < width; ++k) {
      const double* const a = panel + static_cast<std::ptrdiff_t>(k) * ld;
      const double f = a[j];
      for (int i = j; i < n; ++i) column[i] -= f * a[i];
    }
  }
}

}  // namespace

int factorizePivots(double* A, int ld, int rows, int pivots) {
  if (rows <= kSmallFront) {
    const int bad = factorizeColumns(A, ld, rows, pivots);
    if (bad < 0 && rows > pivots) {
      subtractSmall(A + pivots, A + pivots + static_cast<std::ptrdiff_t>(pivots) * ld, ld,
                    rows - pivots, pivots);
    }
    return bad;
  }
  for (int first = 0; first < pivots; first += kBlock) {
    const int width = std::min(kBlock, pivots - first), below = rows - first - width;
    double* const corner = A + first + static_cast<std::ptrdiff_t>(first) * ld;
    if (const int bad = factorizeColumns(corner, ld, width, width); bad >= 0) return first + bad;
    if (below == 0) break;
    double* const panel = corner + width;
    cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, below, width, 1.0,
                corner, ld, panel, ld);
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, below, width, -1.0, panel, ld, 1.0,
                panel + static_cast<std::ptrdiff_t>(width) * ld, ld);
  }
  return -1;
}

void backSubstitute(const double* L, int ld, int rows, int pivots, const double* x, double* y) {
  if (rows > pivots) {
    cblas_dgemv(CblasColMajor, CblasTrans, rows - pivots, pivots, -1.0, L + pivots, ld, x, 1, 1.0,
                y, 1);
  }
  cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, pivots, L, ld, y, 1);
}

}  // namespace dynemo::backend
