#include "front_marginals.h"

#include <Eigen/Dense>
#include <algorithm>

namespace dynemo::backend {
namespace {

using Panel = Eigen::Map<const MatrixX, 0, Eigen::OuterStride<>>;

/// The columns of L of a front, without the row of the right-hand side.
Panel panelOf(const Front& front) {
  const int rows = front.pivot_size + front.row_size;
  return {front.panel.data, rows, front.pivot_size, Eigen::OuterStride<>(rows + 1)};
}

/// The fronts on the paths from the variables to their roots, ascending.
std::vector<int> pathsOf(const FrontTree& tree, std::span<const int> variables) {
  std::vector<char> seen(static_cast<std::size_t>(tree.fronts()), 0);
  std::vector<int> path;
  for (const int v : variables) {
    for (int f = tree.frontOf(v); f >= 0 && !seen[f]; f = tree.front(f).parent) {
      seen[f] = 1;
      path.push_back(f);
    }
  }
  std::sort(path.begin(), path.end(),
            [&](int a, int b) { return tree.front(a).key < tree.front(b).key; });
  return path;
}

/// Right-hand sides on the pivots of some fronts.
class PathSolver {
 public:
  PathSolver(const LiveProblem& problem, const FrontTree& tree, std::span<const int> variables)
      : problem_(problem), tree_(tree), path_(pathsOf(tree, variables)) {
    at_.assign(static_cast<std::size_t>(problem.variables()), -1);
    for (const int f : path_) {
      for (const int v : tree.list(tree.front(f).pivots)) {
        at_[v] = size_;
        size_ += problem.tangentSize(v);
      }
    }
  }
  int size() const { return size_; }
  int at(int variable) const { return at_[variable]; }

  void forward(MatrixX& b) {
    for (const int f : path_) forward(tree_.front(f), b);
  }
  void solve(MatrixX& b) {
    for (const int f : path_) forward(tree_.front(f), b);
    for (auto f = path_.rbegin(); f != path_.rend(); ++f) backward(tree_.front(*f), b);
  }

 private:
  int pivotsAt(const Front& front) const { return at_[tree_.list(front.pivots).front()]; }
  template <class Visit>
  void forEachRow(const Front& front, Visit visit) const {
    int from = 0;
    for (const int v : tree_.list(front.rows)) {
      visit(from, at_[v], problem_.tangentSize(v));
      from += problem_.tangentSize(v);
    }
  }
  void forward(const Front& front, MatrixX& b) {
    if (front.pivot_size == 0) return;
    const Panel L = panelOf(front);
    auto pivots = b.middleRows(pivotsAt(front), front.pivot_size);
    L.topRows(front.pivot_size).triangularView<Eigen::Lower>().solveInPlace(pivots);
    rows_.noalias() = L.bottomRows(front.row_size) * pivots;
    forEachRow(front, [&](int from, int to, int size) {
      b.middleRows(to, size) -= rows_.middleRows(from, size);
    });
  }
  void backward(const Front& front, MatrixX& b) {
    if (front.pivot_size == 0) return;
    const Panel L = panelOf(front);
    rows_.resize(front.row_size, b.cols());
    forEachRow(front, [&](int from, int to, int size) {
      rows_.middleRows(from, size) = b.middleRows(to, size);
    });
    auto pivots = b.middleRows(pivotsAt(front), front.pivot_size);
    pivots.noalias() -= L.bottomRows(front.row_size).transpose() * rows_;
    L.topRows(front.pivot_size).triangularView<Eigen::Lower>().transpose().solveInPlace(pivots);
  }

  const LiveProblem& problem_;
  const FrontTree& tree_;
  std::vector<int> path_, at_;
  int size_ = 0;
  MatrixX rows_;
};

/// Z = H⁻¹ on the pivots and rows of a front, given the same of its parent.
class FrontInverter {
 public:
  FrontInverter(const LiveProblem& problem, const FrontTree& tree)
      : problem_(problem),
        tree_(tree),
        inverse_(static_cast<std::size_t>(tree.fronts())),
        children_(static_cast<std::size_t>(tree.fronts()), 0),
        at_(static_cast<std::size_t>(problem.variables()), -1) {}

  template <class Visit>
  void run(std::span<const int> variables, Visit visit) {
    const std::vector<int> path = pathsOf(tree_, variables);
    std::vector<std::vector<int>> wanted(inverse_.size());
    for (std::size_t i = 0; i < variables.size(); ++i)
      wanted[tree_.frontOf(variables[i])].push_back(static_cast<int>(i));
    std::vector<std::vector<int>> below(inverse_.size());
    std::vector<int> stack;
    for (const int f : path) {
      const int parent = tree_.front(f).parent;
      if (parent < 0) stack.push_back(f);
      if (parent >= 0) below[parent].push_back(f);
    }
    // Depth first, so that only the inverses along one path are held.
    while (!stack.empty()) {
      const int f = stack.back();
      stack.pop_back();
      invert(f);
      place(tree_.front(f));
      for (const int i : wanted[f]) {
        const int at = at_[variables[i]], size = problem_.tangentSize(variables[i]);
        visit(i, inverse_[f].block(at, at, size, size));
      }
      children_[f] = static_cast<int>(below[f].size());
      stack.insert(stack.end(), below[f].begin(), below[f].end());
      release(f);
    }
  }

 private:
  void place(const Front& front) {
    int at = 0;
    for (const auto& list : {tree_.list(front.pivots), tree_.list(front.rows)}) {
      for (const int v : list) {
        at_[v] = at;
        at += problem_.tangentSize(v);
      }
    }
  }
  /// Frees what no child needs any more.
  void release(int f) {
    if (children_[f] > 0) return;
    inverse_[f].resize(0, 0);
    const int parent = tree_.front(f).parent;
    if (parent >= 0 && --children_[parent] == 0) inverse_[parent].resize(0, 0);
  }
  MatrixX gather(const Front& front) {
    place(tree_.front(front.parent));
    const MatrixX& Z = inverse_[front.parent];
    MatrixX out(front.row_size, front.row_size);
    int column = 0;
    for (const int b : tree_.list(front.rows)) {
      int row = 0;
      for (const int a : tree_.list(front.rows)) {
        out.block(row, column, problem_.tangentSize(a), problem_.tangentSize(b)) =
            Z.block(at_[a], at_[b], problem_.tangentSize(a), problem_.tangentSize(b));
        row += problem_.tangentSize(a);
      }
      column += problem_.tangentSize(b);
    }
    return out;
  }
  void invert(int f) {
    const Front& front = tree_.front(f);
    const int p = front.pivot_size, r = front.row_size;
    MatrixX& Z = inverse_[f];
    Z.resize(p + r, p + r);
    const Panel L = panelOf(front);
    const MatrixX L_inverse =
        L.topRows(p).triangularView<Eigen::Lower>().solve(MatrixX::Identity(p, p));
    Z.topLeftCorner(p, p).noalias() = L_inverse.transpose() * L_inverse;
    if (r == 0) return;
    const MatrixX Y = L.bottomRows(r) * L_inverse;
    Z.bottomRightCorner(r, r) = gather(front);
    Z.bottomLeftCorner(r, p).noalias() = -Z.bottomRightCorner(r, r) * Y;
    Z.topRightCorner(p, r) = Z.bottomLeftCorner(r, p).transpose();
    Z.topLeftCorner(p, p).noalias() -= Y.transpose() * Z.bottomLeftCorner(r, p);
  }

  const LiveProblem& problem_;
  const FrontTree& tree_;
  std::vector<MatrixX> inverse_;
  std::vector<int> children_, at_;
};

}  // namespace

MatrixX jointCovariance(const LiveProblem& problem, const FrontFactor& factor,
                        std::span<const int> variables) {
  PathSolver solver(problem, factor.tree(), variables);
  std::vector<int> entries;
  for (const int v : variables)
    for (int i = 0; i < problem.tangentSize(v); ++i) entries.push_back(solver.at(v) + i);
  const auto n = static_cast<Eigen::Index>(entries.size());
  MatrixX columns = MatrixX::Zero(solver.size(), n);
  for (Eigen::Index c = 0; c < n; ++c) columns(entries[c], c) = 1.0;
  solver.solve(columns);
  MatrixX joint(n, n);
  for (Eigen::Index r = 0; r < n; ++r) joint.row(r) = columns.row(entries[r]);
  return 0.5 * (joint + joint.transpose());
}

MatrixX quadraticForm(const LiveProblem& problem, const FrontFactor& factor, const MatrixX& A) {
  std::vector<int> variables;
  for (int v = 0; v < problem.variables(); ++v) {
    const auto rows = A.middleRows(problem.tangentOffset(v), problem.tangentSize(v));
    if (problem.alive(v) && !rows.isZero(0.0)) variables.push_back(v);
  }
  PathSolver solver(problem, factor.tree(), variables);
  MatrixX b = MatrixX::Zero(solver.size(), A.cols());
  for (const int v : variables)
    b.middleRows(solver.at(v), problem.tangentSize(v)) =
        A.middleRows(problem.tangentOffset(v), problem.tangentSize(v));
  solver.forward(b);
  return b.transpose() * b;
}

std::vector<MatrixX> blockCovariances(const LiveProblem& problem, const FrontFactor& factor,
                                      std::span<const int> variables) {
  std::vector<MatrixX> blocks(variables.size());
  FrontInverter(problem, factor.tree()).run(variables, [&](int i, const auto& block) {
    blocks[i] = 0.5 * (block + block.transpose());
  });
  return blocks;
}

}  // namespace dynemo::backend
