#include "front_paths.h"

#include <Eigen/Dense>

namespace dynemo::backend {

MatrixX covariance(const PathColumns& a, const PathColumns& b) {
  MatrixX sum = MatrixX::Zero(a.parts.front().cols(), b.parts.front().cols());
  auto i = a.fronts.size(), j = b.fronts.size();
  // Paths of a tree meet once and stay together from there.
  while (i-- > 0 && j-- > 0 && a.fronts[i] == b.fronts[j])
    sum.noalias() += a.parts[i].transpose() * b.parts[j];
  return sum;
}

PathColumns PathTracer::trace(const LiveProblem& problem, const FrontTree& tree, int variable) {
  const int columns = problem.tangentSize(variable);
  if (carried_.rows() < problem.tangentSize()) carried_ = MatrixX::Zero(problem.tangentSize(), 6);
  carried_.block(problem.tangentOffset(variable), 0, columns, columns).setIdentity();
  PathColumns path;
  for (int f = tree.frontOf(variable); f >= 0; f = tree.front(f).parent) {
    const Front& front = tree.front(f);
    if (front.pivot_size == 0) continue;
    const int n = front.pivot_size + front.row_size;
    const Eigen::Map<const MatrixX, 0, Eigen::OuterStride<>> L(
        front.panel.data, n, front.pivot_size, Eigen::OuterStride<>(n + 1));
    MatrixX y(front.pivot_size, columns);
    int at = 0;
    for (const int v : tree.list(front.pivots)) {
      const int size = problem.tangentSize(v);
      auto known = carried_.block(problem.tangentOffset(v), 0, size, columns);
      y.middleRows(at, size) = known;
      known.setZero();
      at += size;
    }
    L.topRows(front.pivot_size).triangularView<Eigen::Lower>().solveInPlace(y);
    rows_.noalias() = L.bottomRows(front.row_size) * y;
    at = 0;
    for (const int v : tree.list(front.rows)) {
      const int size = problem.tangentSize(v);
      carried_.block(problem.tangentOffset(v), 0, size, columns) -= rows_.middleRows(at, size);
      at += size;
    }
    path.fronts.push_back(f);
    path.parts.push_back(std::move(y));
  }
  return path;
}

}  // namespace dynemo::backend
