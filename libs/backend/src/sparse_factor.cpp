#include "sparse_factor.h"

#include <stdexcept>

namespace dynemo::backend {
namespace {

cholmod_dense denseView(const double* values, std::size_t rows, std::size_t columns) {
  cholmod_dense view{};
  view.nrow = view.d = rows;
  view.ncol = columns;
  view.nzmax = rows * columns;
  view.x = const_cast<double*>(values);  // CHOLMOD only reads a right-hand side
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

}  // namespace

SparseFactor::SparseFactor(const BlockStructure& structure, CholmodContext& context, Kind kind)
    : context_(&context),
      factor_(nullptr, {&context}),
      solution_(nullptr, {&context}),
      work_y_(nullptr, {&context}),
      work_e_(nullptr, {&context}) {
  // The structure is already in elimination order, and post-ordered.
  context->nmethods = 1;
  context->method[0].ordering = CHOLMOD_NATURAL;
  context->postorder = 0;
  context->supernodal = kind == Kind::kSupernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_AUTO;
  cholmod_sparse H = structure.view(nullptr);
  factor_.reset(cholmod_analyze(&H, context.get()));
  if (!factor_) throw std::runtime_error("out of memory in the symbolic factorisation");
  fill_ = context->lnz;
}

std::optional<int> SparseFactor::factorize(const BlockStructure& structure,
                                           std::vector<double>& hessian) {
  const SingleThreaded single_threaded;
  cholmod_sparse H = structure.view(hessian.data());
  (*context_)->supernodal = factor_->is_super ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
  if (!cholmod_factorize(&H, factor_.get(), context_->get())) {
    throw std::runtime_error("out of memory in the numeric factorisation");
  }
  if (factor_->minor < factor_->n) return static_cast<int>(factor_->minor);
  return std::nullopt;
}

void SparseFactor::solve(const VectorX& b, VectorX& x) {
  const SingleThreaded single_threaded;
  cholmod_dense rhs = denseView(b.data(), static_cast<std::size_t>(b.size()), 1);
  cholmod_dense *X = solution_.release(), *Y = work_y_.release(), *E = work_e_.release();
  const int ok =
      cholmod_solve2(CHOLMOD_A, factor_.get(), &rhs, nullptr, &X, nullptr, &Y, &E, context_->get());
  solution_.reset(X);
  work_y_.reset(Y);
  work_e_.reset(E);
  if (!ok) throw std::runtime_error("out of memory in the triangular solution");
  x = Eigen::Map<const VectorX>(static_cast<const double*>(X->x), b.size());
}

MatrixX SparseFactor::solve(const MatrixX& b) {
  const SingleThreaded single_threaded;
  cholmod_dense rhs =
      denseView(b.data(), static_cast<std::size_t>(b.rows()), static_cast<std::size_t>(b.cols()));
  const DensePtr X(cholmod_solve(CHOLMOD_A, factor_.get(), &rhs, context_->get()), {context_});
  if (!X) throw std::runtime_error("out of memory in the triangular solution");
  return Eigen::Map<const MatrixX>(static_cast<const double*>(X->x), b.rows(), b.cols());
}

VectorX SparseFactor::diagonal() const {
  VectorX d(static_cast<Eigen::Index>(factor_->n));
  const double* x = static_cast<const double*>(factor_->x);
  if (!factor_->is_super) {
    const int* begin = static_cast<const int*>(factor_->p);
    for (Eigen::Index c = 0; c < d.size(); ++c) d[c] = x[begin[c]];
    return d;
  }
  const int *super = static_cast<const int*>(factor_->super),
            *pi = static_cast<const int*>(factor_->pi), *px = static_cast<const int*>(factor_->px);
  for (std::size_t s = 0; s < factor_->nsuper; ++s) {
    const int rows = pi[s + 1] - pi[s];
    for (int c = super[s]; c < super[s + 1]; ++c) d[c] = x[px[s] + (c - super[s]) * (rows + 1)];
  }
  return d;
}

}  // namespace dynemo::backend
