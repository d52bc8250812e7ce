#include "cholmod_context.h"

#include <mutex>

// Present when the system's BLAS is OpenBLAS; other implementations run on one thread anyway.
extern "C" {
[[gnu::weak]] void openblas_set_num_threads(int threads);
[[gnu::weak]] int openblas_get_num_threads(void);
// Present when CHOLMOD uses OpenMP.
[[gnu::weak]] void omp_set_max_active_levels(int levels);
[[gnu::weak]] int omp_get_max_active_levels(void);
}

namespace dynemo::backend {

CholmodContext::CholmodContext() {
  cholmod_start(&common_);
  common_.print = 0;
  common_.try_catch = 1;
  common_.quick_return_if_not_posdef = 1;
  common_.final_ll = 1;
}

CholmodContext::~CholmodContext() { cholmod_finish(&common_); }

cholmod_sparse lowerTriangleView(int size, int* column_begin, int* rows, double* values) {
  cholmod_sparse A{};
  A.nrow = A.ncol = static_cast<std::size_t>(size);
  A.nzmax = static_cast<std::size_t>(column_begin[size]);
  A.p = column_begin;
  A.i = rows;
  A.x = values;
  A.stype = -1;
  A.itype = CHOLMOD_INT;
  A.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  A.dtype = CHOLMOD_DOUBLE;
  A.sorted = 1;
  A.packed = 1;
  return A;
}

namespace {

/// The setting of the BLAS belongs to the process: the last one to leave restores it.
std::mutex blas_mutex;
int blas_users = 0, blas_threads_before = 1;

}  // namespace

SingleThreaded::SingleThreaded()
    : levels_before_(omp_get_max_active_levels ? omp_get_max_active_levels() : 0) {
  // Each thread's own.
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
  if (!openblas_get_num_threads || !openblas_set_num_threads) return;
  const std::lock_guard lock(blas_mutex);
  if (blas_users++ > 0) return;
  blas_threads_before = openblas_get_num_threads();
  if (blas_threads_before != 1) openblas_set_num_threads(1);
}

SingleThreaded::~SingleThreaded() {
  if (omp_set_max_active_levels) omp_set_max_active_levels(levels_before_);
  if (!openblas_get_num_threads || !openblas_set_num_threads) return;
  const std::lock_guard lock(blas_mutex);
  if (--blas_users == 0 && blas_threads_before != 1) openblas_set_num_threads(blas_threads_before);
}

}  // namespace dynemo::backend
