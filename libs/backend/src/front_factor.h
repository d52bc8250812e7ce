// The multifrontal Cholesky factorisation of a live problem, kept up to date front by front.
//
// Each front stores its columns of L, and the matrix that its elimination leaves to its parent. A
// change assembles and eliminates the dirty fronts again, from their own factors and the stored
// matrices of all their children. The right-hand side −g is one more row of every front, so that
// the forward substitution comes with the elimination; the sum of squares that it leaves is twice
// the decrease of the quadratic model. What corrections change of it (live_problem.h) is carried up
// with the factorisation as it is.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "block_arena.h"
#include "front_tree.h"
#include "live_problem.h"

namespace dynemo::backend {

/// One more term of the cost, on the clique of the tree (front_tree.h).
struct DensePrior {
  const MatrixX* information;
  const VectorX* gradient;  ///< at the linearisation
};

/// Has the front's columns of L on their way from memory before they are used.
void prefetchPanel(const Front& front);

class FrontFactor {
 public:
  /// Lays out the problem anew, in a fresh order or the given one; nothing is factorised yet.
  void build(const LiveProblem& problem, CholmodContext& context);
  void build(const LiveProblem& problem, const Elimination& elimination, CholmodContext& context);
  FrontTree& tree() { return tree_; }
  const FrontTree& tree() const { return tree_; }

  /// Factorises what is dirty. Returns the variable where the matrix is singular or indefinite; the
  /// factorisation must then be built anew.
  std::optional<int> factorize(LiveProblem& problem, const DensePrior& prior = {});
  /// From the next factorize() on, H + λ D, where D is the diagonal of H with the mean of each
  /// three axes of a pose, which does not depend on how they happen to lie.
  void setDamping(double lambda) { lambda_ = lambda; }
  /// Whether fronts keep what they leave to their parents, without which every factorize() must be
  /// of all. True unless told otherwise.
  void keepUpdates(bool keep) {
    keep_updates_ = keep;
    arena_.keepBig(!keep);
  }
  /// D, by tangent entry, of the last factorize() with a damping.
  const std::vector<double>& scale() const { return scale_; }
  /// Flops and fronts of the last factorize().
  double lastFlops() const { return last_flops_; }
  int lastFronts() const { return last_fronts_; }

  /// Corrects the factors where the estimates are, and the right-hand side with them. Returns the
  /// decrease that the model then predicts, from the minimum of the model before. Everything must
  /// be factorised.
  double correct(LiveProblem& problem, std::span<const int> factors);
  /// δ is zero at a variable that was linearised anew.
  void forget(const LiveProblem& problem, int variable);

  /// Brings δ up to date, from the roots down, as far as it changes: below variables that moved by
  /// no more than `tolerance` standard deviations (given the variables that are eliminated later)
  /// since they were last carried down, nothing is visited. Returns the variables that moved by
  /// more, and those of fronts that have been factorised or corrected that moved at all: the newest
  /// ones are exact.
  const std::vector<int>& solve(LiveProblem& problem, double tolerance);
  /// Largest entry of the change of a variable's δ that was carried down in that solution [m, rad].
  double lastStep(int variable) const { return moved_[variable]; }

  /// The same for all variables with another gradient, and the factorisation as it is.
  void solve(LiveProblem& problem, const std::vector<double>& gradient);

  /// F(x₀) − min of the quadratic model, ½ ‖y‖².
  double modelDecrease() const;
  std::size_t storedDoubles() const { return arena_.capacity(); }

 private:
  void collectPaths(const LiveProblem& problem, std::span<const int> factors);
  double carryUp(const LiveProblem& problem, int front);
  bool factorizeFront(LiveProblem& problem, int front, const DensePrior& prior);
  double* entry(int row, int column) {
    return &matrix_[static_cast<std::size_t>(column) * ld_ + row];
  }
  const double* entry(int row, int column) const {
    return &matrix_[static_cast<std::size_t>(column) * ld_ + row];
  }
  void placeRows(const LiveProblem& problem, const Front& front);
  void assembleFactors(LiveProblem& problem, const Front& front);
  void assemblePrior(const LiveProblem& problem, const Front& front, const DensePrior& prior);
  void assembleChild(const LiveProblem& problem, const Front& child);
  void damp(const LiveProblem& problem, const Front& front);
  bool pivotsAreSound(const Front& front) const;
  void storeFront(Front& front);
  void solveFront(LiveProblem& problem, int front, double tolerance);

  FrontTree tree_;
  BlockArena arena_;
  /// Of the front in work: the lower triangle, with the right-hand side as the last row, padded for
  /// the kernels.
  std::vector<double> matrix_;
  int side_ = 0, ld_ = 0;         ///< the row of the right-hand side, the leading dimension
  std::vector<double> diagonal_;  ///< of H, before any elimination, of the front in work
  std::vector<int> place_;        ///< per variable, in the front in work
  std::vector<char> recompute_;   ///< per front
  std::vector<int> factorized_;
  double lambda_ = 0.0;
  bool keep_updates_ = true;
  std::vector<double> scale_, rest_;
  std::vector<double> carried_;  ///< δ as the fronts below last saw it
  std::vector<double> moved_;    ///< per variable, in the solution in work
  std::vector<int> changed_, stack_;
  std::vector<double> x_, y_;
  std::vector<std::pair<int, int>> corrected_;   ///< (front, factor), children first
  std::vector<int> paths_;                       ///< fronts, children first
  std::vector<char> is_on_path_;                 ///< per front
  std::vector<std::vector<double>> carried_up_;  ///< per front, what it adds to its parent's side
  double last_flops_ = 0.0;
  int last_fronts_ = 0, singular_ = -1;
};

}  // namespace dynemo::backend
