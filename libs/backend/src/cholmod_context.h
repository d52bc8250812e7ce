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

/// Keeps the BLAS and OpenMP, with which CHOLMOD may have been built, on the calling thread while
/// it lives: a reduction split over threads would make the last bits depend on how many there are,
/// and threads that wait for each other's small shares cost more than they do.
class SingleThreaded {
 public:
  SingleThreaded();
  ~SingleThreaded();
  SingleThreaded(const SingleThreaded&) = delete;
  SingleThreaded& operator=(const SingleThreaded&) = delete;

 private:
  int levels_before_;
};

}  // namespace dynemo::backend
