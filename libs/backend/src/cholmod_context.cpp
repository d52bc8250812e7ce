#include "cholmod_context.h"

// Present when the system's BLAS is OpenBLAS; other implementations run on one thread anyway.
extern "C" {
[[gnu::weak]] void openblas_set_num_threads(int threads);
[[gnu::weak]] int openblas_get_num_threads(void);
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

SingleThreadedBlas::SingleThreadedBlas()
    : threads_before_(openblas_get_num_threads ? openblas_get_num_threads() : 1) {
  if (openblas_set_num_threads && threads_before_ != 1) openblas_set_num_threads(1);
}

SingleThreadedBlas::~SingleThreadedBlas() {
  if (openblas_set_num_threads && threads_before_ != 1) openblas_set_num_threads(threads_before_);
}

}  // namespace dynemo::backend
