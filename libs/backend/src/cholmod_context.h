// Ownership of CHOLMOD's objects.
#pragma once

#include <cholmod.h>

#include <memory>

namespace dynemo::backend {

/// CHOLMOD's workspace and settings. Silent: failures are read from its status.
class CholmodContext {
 public:
  CholmodContext();
  ~CholmodContext();
  CholmodContext(const CholmodContext&) = delete;
  CholmodContext& operator=(const CholmodContext&) = delete;

  cholmod_common* get() { return &common_; }
  cholmod_common* operator->() { return &common_; }

 private:
  cholmod_common common_{};
};

struct FactorDeleter {
  CholmodContext* context;
  void operator()(cholmod_factor* factor) const { cholmod_free_factor(&factor, context->get()); }
};
struct DenseDeleter {
  CholmodContext* context;
  void operator()(cholmod_dense* dense) const { cholmod_free_dense(&dense, context->get()); }
};
using FactorPtr = std::unique_ptr<cholmod_factor, FactorDeleter>;
using DensePtr = std::unique_ptr<cholmod_dense, DenseDeleter>;

/// A symmetric matrix of which CHOLMOD reads the lower triangle; the arrays stay the caller's.
/// Without values it is a pattern.
cholmod_sparse lowerTriangleView(int size, int* column_begin, int* rows, double* values);

/// Keeps the BLAS on the calling thread while it lives: a reduction split over threads would make
/// the last bits depend on how many there are.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;

 private:
  int threads_before_;
};

}  // namespace dynemo::backend
