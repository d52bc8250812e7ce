#include "front_factor.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "dense_kernels.h"

namespace dynemo::backend {
namespace {

/// A pivot below this fraction of its diagonal entry is what rounding leaves of zero.
constexpr double kSingularPivot = 1e-13;

/// Keeps directions that no residual sees from making the damped matrix singular.
constexpr double kMinScale = 1e-6;

std::size_t square(int n) { return static_cast<std::size_t>(n) * static_cast<std::size_t>(n); }
/// Entries of the lower triangle of the update matrix with its right-hand side, and of the diagonal
/// of H that goes with its rows.
std::size_t updateSize(int rows) {
  const auto n = static_cast<std::size_t>(rows) + 1;
  return n * (n + 1) / 2 + static_cast<std::size_t>(rows);
}

}  // namespace

void prefetchPanel(const Front& front) {
  constexpr int kLine = 64 / sizeof(double), kMost = 1 << 13;
  const int size = front.pivot_size * (front.pivot_size + front.row_size + 1);
  for (int i = 0; i < std::min(size, kMost); i += kLine) __builtin_prefetch(front.panel.data + i);
}

void FrontFactor::build(const LiveProblem& problem, CholmodContext& context) {
  build(problem, tree_.order(problem, context), context);
}

void FrontFactor::build(const LiveProblem& problem, const Elimination& elimination,
                        CholmodContext& context) {
  arena_.clear();
  tree_.build(problem, elimination, context);
  recompute_.clear();
  carried_.assign(static_cast<std::size_t>(problem.tangentSize()), 0.0);
}

std::optional<int> FrontFactor::factorize(LiveProblem& problem, const DensePrior& prior) {
  last_flops_ = 0.0;
  last_fronts_ = 0;
  place_.resize(static_cast<std::size_t>(problem.variables()), -1);
  recompute_.resize(static_cast<std::size_t>(tree_.fronts()), 0);
  for (int f = tree_.nextDirty(problem); f >= 0; f = tree_.nextDirty(problem)) {
    if (!factorizeFront(problem, f, prior)) return singular_;
    recompute_[f] = 1;
    last_flops_ += tree_.front(f).flops();
    ++last_fronts_;
  }
  return std::nullopt;
}

bool FrontFactor::factorizeFront(LiveProblem& problem, int f, const DensePrior& prior) {
  Front& front = tree_.front(f);
  side_ = front.pivot_size + front.row_size;
  ld_ = side_ + 1 + kPaddingRows;
  if (matrix_.size() < square(ld_)) matrix_.resize(square(ld_));
  for (int j = 0; j <= side_; ++j) std::fill(entry(j, j), entry(0, j + 1), 0.0);
  diagonal_.assign(static_cast<std::size_t>(side_), 0.0);
  placeRows(problem, front);
  assembleFactors(problem, front);
  if (prior.information) assemblePrior(problem, front, prior);
  for (int c = front.first_child; c >= 0; c = tree_.front(c).next_sibling)
    assembleChild(problem, tree_.front(c));
  for (int c = front.first_child; !keep_updates_ && c >= 0; c = tree_.front(c).next_sibling)
    arena_.release(tree_.front(c).update);
  if (lambda_ > 0.0) damp(problem, front);
  const int bad = factorizePivots(matrix_.data(), ld_, side_ + 1, front.pivot_size);
  if (bad >= 0 || (lambda_ == 0.0 && !pivotsAreSound(front))) {
    singular_ = tree_.list(front.pivots).front();
    for (const int v : tree_.list(front.pivots))
      if (bad >= 0 && place_[v] <= bad) singular_ = v;
    return false;
  }
  storeFront(front);
  return true;
}

void FrontFactor::placeRows(const LiveProblem& problem, const Front& front) {
  int at = 0;
  for (const auto& list : {tree_.list(front.pivots), tree_.list(front.rows)}) {
    for (const int v : list) {
      place_[v] = at;
      at += problem.tangentSize(v);
    }
  }
}

void FrontFactor::assembleFactors(LiveProblem& problem, const Front& front) {
  for (const int pivot : tree_.list(front.pivots))
    tree_.forEachOwnedFactor(pivot, [&](int f) { problem.prefetch(f); });
  WhitenedFactor work;
  for (const int pivot : tree_.list(front.pivots)) {
    tree_.forEachOwnedFactor(pivot, [&](int f) {
      problem.linearize(f, work);
      const auto variables = problem.variablesOf(f);
      for (std::size_t a = 0; a < variables.size(); ++a) {
        if (problem.tangentSize(variables[a]) == 0) continue;  // a constant
        const int row = place_[variables[a]];
        const JacobianBlock& A = work.J[a];
        for (int i = 0; i < A.cols(); ++i) {
          *entry(side_, row + i) -= A.col(i).dot(work.e);
          diagonal_[row + i] += A.col(i).squaredNorm();
        }
        for (std::size_t b = 0; b < variables.size(); ++b) {
          if (problem.tangentSize(variables[b]) == 0) continue;
          const int column = place_[variables[b]];
          if (row > column || (row == column && a >= b))
            addProduct(A, work.J[b], entry(row, column), ld_);
          if (row == column && a > b) addProduct(work.J[b], A, entry(row, column), ld_);
        }
      }
    });
  }
}

void FrontFactor::assemblePrior(const LiveProblem& problem, const Front& front,
                                const DensePrior& prior) {
  for (const int a : tree_.list(front.pivots)) {
    if (a >= tree_.clique()) continue;
    const int from = problem.tangentOffset(a);
    for (int i = 0; i < problem.tangentSize(a); ++i) {
      *entry(side_, place_[a] + i) -= (*prior.gradient)[from + i];
      diagonal_[place_[a] + i] += (*prior.information)(from + i, from + i);
    }
    for (int b = 0; b < tree_.clique(); ++b) {
      if (tree_.position(b) < tree_.position(a)) continue;
      for (int j = 0; j < problem.tangentSize(a); ++j) {
        double* const column = entry(place_[b], place_[a] + j);
        for (int i = 0; i < problem.tangentSize(b); ++i)
          column[i] += (*prior.information)(problem.tangentOffset(b) + i, from + j);
      }
    }
  }
}

void FrontFactor::assembleChild(const LiveProblem& problem, const Front& child) {
  // Rows of the child that are neighbours here too are added as one run.
  struct Run {
    int from, to, size;
  };
  thread_local std::vector<Run> runs;
  runs.clear();
  int from = 0;
  for (const int v : tree_.list(child.rows)) {
    const int size = problem.tangentSize(v);
    if (!runs.empty() && runs.back().to + runs.back().size == place_[v]) {
      runs.back().size += size;
    } else {
      runs.push_back({from, place_[v], size});
    }
    from += size;
  }
  runs.push_back({from, side_, 1});  // the right-hand side
  const double* source = child.update.data;
  const int n = from + 1;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (int j = 0; j < runs[r].size; ++j) {
      const int column = runs[r].from + j;
      double* const target = entry(0, runs[r].to + j);
      // The packed column starts at its diagonal.
      const double* const packed = source - column;
      for (int i = j; i < runs[r].size; ++i) target[runs[r].to + i] += packed[runs[r].from + i];
      for (std::size_t below = r + 1; below < runs.size(); ++below) {
        const Run& run = runs[below];
        for (int i = 0; i < run.size; ++i) target[run.to + i] += packed[run.from + i];
      }
      source += n - column;
    }
  }
  for (std::size_t r = 0; r + 1 < runs.size(); ++r)
    for (int i = 0; i < runs[r].size; ++i) diagonal_[runs[r].to + i] += source[runs[r].from + i];
}

void FrontFactor::damp(const LiveProblem& problem, const Front& front) {
  constexpr int kAxes = 3;
  scale_.resize(static_cast<std::size_t>(problem.tangentSize()));
  for (const int v : tree_.list(front.pivots)) {
    for (int first = 0; first < problem.tangentSize(v); first += kAxes) {
      const int count = std::min(kAxes, problem.tangentSize(v) - first);
      double sum = 0.0;
      for (int i = first; i < first + count; ++i) sum += diagonal_[place_[v] + i];
      const double scale = std::max(sum / count, kMinScale);
      for (int i = first; i < first + count; ++i) {
        scale_[problem.tangentOffset(v) + i] = scale;
        *entry(place_[v] + i, place_[v] + i) += lambda_ * scale;
      }
    }
  }
}

bool FrontFactor::pivotsAreSound(const Front& front) const {
  for (int i = 0; i < front.pivot_size; ++i) {
    const double pivot = *entry(i, i);
    if (!(pivot * pivot > kSingularPivot * diagonal_[i])) return false;
  }
  return true;
}

void FrontFactor::storeFront(Front& front) {
  const int p = front.pivot_size, rows = side_ + 1;
  arena_.reserve(front.panel, static_cast<std::size_t>(rows) * static_cast<std::size_t>(p));
  front.half_squared_y = 0.0;
  for (int j = 0; j < p; ++j) {
    std::copy_n(entry(j, j), rows - j, front.panel.data + static_cast<std::size_t>(j) * rows + j);
    const double y = *entry(side_, j);
    front.half_squared_y += 0.5 * y * y;
  }
  arena_.reserve(front.update, updateSize(front.row_size));
  double* out = front.update.data;
  for (int j = p; j < rows; ++j) out = std::copy_n(entry(j, j), rows - j, out);
  std::copy_n(diagonal_.begin() + p, front.row_size, out);
}

const std::vector<int>& FrontFactor::solve(LiveProblem& problem, double tolerance) {
  changed_.clear();
  moved_.assign(static_cast<std::size_t>(problem.variables()), 0.0);
  carried_.resize(static_cast<std::size_t>(problem.tangentSize()), 0.0);
  stack_ = tree_.roots();
  while (!stack_.empty()) {
    const int f = stack_.back();
    stack_.pop_back();
    const Front& front = tree_.front(f);
    const auto any_moved = [&](const Front::List& l) {
      const auto list = tree_.list(l);
      return std::any_of(list.begin(), list.end(), [&](int v) { return moved_[v] != 0.0; });
    };
    const bool rows_moved = any_moved(front.rows);
    if (recompute_[f] || rows_moved) solveFront(problem, f, tolerance);
    // Dirty fronts lie below dirty ones.
    if (recompute_[f] || rows_moved || any_moved(front.pivots)) {
      for (int c = front.first_child; c >= 0; c = tree_.front(c).next_sibling) {
        if (recompute_[c] || any_moved(tree_.front(c).rows)) prefetchPanel(tree_.front(c));
        stack_.push_back(c);
      }
    }
    recompute_[f] = 0;
  }
  return changed_;
}

void FrontFactor::solve(LiveProblem& problem, const std::vector<double>& gradient) {
  rest_.resize(gradient.size());
  std::transform(gradient.begin(), gradient.end(), rest_.begin(), std::negate<>());
  for (const int f : tree_.ascending()) {
    Front& front = tree_.front(f);
    const int p = front.pivot_size, n = p + front.row_size, ld = n + 1;
    x_.resize(static_cast<std::size_t>(n) + 1);
    const auto forEach = [&](auto visit) {
      int at = 0;
      for (const auto& list : {tree_.list(front.pivots), tree_.list(front.rows)}) {
        for (const int v : list) {
          visit(rest_.data() + problem.tangentOffset(v), &x_[at], problem.tangentSize(v));
          at += problem.tangentSize(v);
        }
      }
    };
    forEach([](const double* rest, double* x, int size) { std::copy_n(rest, size, x); });
    double* const L = front.panel.data;
    forwardSubstitute(L, ld, n, p, x_.data());
    forEach([](double* rest, const double* x, int size) { std::copy_n(x, size, rest); });
    front.half_squared_y = 0.0;
    for (int j = 0; j < p; ++j) {
      L[static_cast<std::size_t>(j) * ld + ld - 1] = x_[j];
      front.half_squared_y += 0.5 * x_[j] * x_[j];
    }
    recompute_[f] = 1;
  }
  solve(problem, 0.0);
}

void FrontFactor::solveFront(LiveProblem& problem, int f, double tolerance) {
  const Front& front = tree_.front(f);
  const int p = front.pivot_size, n = p + front.row_size, ld = n + 1;
  x_.resize(static_cast<std::size_t>(n) + 1);
  y_.resize(static_cast<std::size_t>(p));
  int at = 0;
  for (const int v : tree_.list(front.rows)) {
    std::copy_n(problem.delta(v), problem.tangentSize(v), &x_[at]);
    at += problem.tangentSize(v);
  }
  // What is decided about the newest nodes rests on where they are.
  const bool is_new = recompute_[f] != 0;
  const double* const L = front.panel.data;
  for (int j = 0; j < p; ++j) y_[j] = L[static_cast<std::size_t>(j) * ld + ld - 1];
  backSubstitute(L, ld, n, p, x_.data(), y_.data());
  at = 0;
  for (const int v : tree_.list(front.pivots)) {
    double* const delta = problem.delta(v);
    double* const carried = carried_.data() + problem.tangentOffset(v);
    double step = 0.0, deviations = 0.0;
    for (int i = 0; i < problem.tangentSize(v); ++i, ++at) {
      delta[i] = y_[at];
      const double change = std::abs(delta[i] - carried[i]);
      step = std::max(step, change);
      // The diagonal of L has the inverse deviation, given what is eliminated later.
      deviations = std::max(deviations, change * L[static_cast<std::size_t>(at) * ld + at]);
    }
    if (!(deviations <= tolerance)) {
      changed_.push_back(v);
      moved_[v] = step;
      std::copy_n(delta, problem.tangentSize(v), carried);
    } else if (is_new && step > 0.0) {
      changed_.push_back(v);
    }
  }
}

double FrontFactor::modelDecrease() const {
  double sum = 0.0;
  for (int f = 0; f < tree_.fronts(); ++f) sum += tree_.front(f).half_squared_y;
  return sum;
}

}  // namespace dynemo::backend
