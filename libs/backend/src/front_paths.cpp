#include "front_paths.h"

#include <Eigen/Dense>
#include <algorithm>

#include "dense_kernels.h"

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
  const auto sides = [&](int v) {
    return carried_.begin() + static_cast<std::ptrdiff_t>(kSides) * problem.tangentOffset(v);
  };
  const int columns = problem.tangentSize(variable);
  carried_.resize(kSides * static_cast<std::size_t>(problem.tangentSize()), 0.0);
  for (int i = 0; i < columns; ++i) sides(variable)[(kSides + 1) * i] = 1.0;
  PathColumns path;
  for (int f = tree.frontOf(variable); f >= 0; f = tree.front(f).parent) {
    const Front& front = tree.front(f);
    const int p = front.pivot_size, n = p + front.row_size;
    if (p == 0) continue;
    x_.clear();
    for (const auto& list : {tree.list(front.pivots), tree.list(front.rows)})
      for (const int v : list)
        x_.insert(x_.end(), sides(v), sides(v) + kSides * problem.tangentSize(v));
    forwardSubstituteSides(front.panel.data, n + 1, n, p, x_.data());
    const Eigen::Map<const MatrixX> x(x_.data(), kSides, n);
    path.fronts.push_back(f);
    path.parts.emplace_back(x.topLeftCorner(columns, p).transpose());
    for (const int v : tree.list(front.pivots))
      std::fill_n(sides(v), kSides * problem.tangentSize(v), 0.0);
    auto rest = x_.begin() + kSides * static_cast<std::ptrdiff_t>(p);
    for (const int v : tree.list(front.rows)) {
      std::copy_n(rest, kSides * problem.tangentSize(v), sides(v));
      rest += kSides * problem.tangentSize(v);
    }
  }
  return path;
}

}  // namespace dynemo::backend
