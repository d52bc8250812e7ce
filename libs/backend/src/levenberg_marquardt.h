// Levenberg–Marquardt on flat states.
//
// A step solves (H + λ D) d = −g, D a positive diagonal. λ starts almost at zero, so that from a
// warm start the first step is a Gauss–Newton step, and follows the gain ratio (Nielsen, "Damping
// parameter in Marquardt's method", 1999). After an accepted step the old factor is used again on
// the new gradient for as long as that contracts fast (the simplified Newton method): the
// factorisations that would only confirm the minimum are saved.
#pragma once

#include "dynemo/backend/optimizer.h"
#include "linearize.h"
#include "sparse_factor.h"

namespace dynemo::backend {

class LevenbergMarquardt {
 public:
  LevenbergMarquardt(const SolverParams& params, const Problem& problem,
                     const BlockStructure& structure, SparseFactor& factor,
                     OptimizationReport& report);

  /// Minimises from `states`, which end at the best estimate found. Fills the report.
  void run(std::vector<double>& states);

 private:
  enum class Trial { kAccepted, kRejected, kFailed };

  void linearizeAt(const std::vector<double>& states);
  void scaleDamping();
  bool factorizeDamped();
  void solveStep();
  Trial tryStep(std::vector<double>& states);
  void accept(std::vector<double>& states, double cost);
  /// Raises λ; false when there is no more room.
  bool raiseDamping();
  void lowerDamping(double gain_ratio);
  /// Steps with the factor of an earlier linearisation; true when they reached the minimum.
  bool finishWithOldFactor(std::vector<double>& states);
  /// Cost at states ⊞ step_, which candidate_ holds then.
  double tryCost(const std::vector<double>& states);
  void stop(StopReason reason) { report_.stop = reason; }
  void fail(const std::vector<double>& states);

  const SolverParams& params_;
  const Problem& problem_;
  const BlockStructure& structure_;
  SparseFactor& factor_;
  OptimizationReport& report_;

  NormalEquations equations_;
  VectorX scale_, step_, negative_gradient_;
  std::vector<double> candidate_;
  double lambda_, raise_ = 2.0;
  double predicted_ = 0.0, decrease_ = 0.0;
  int failed_pivot_ = -1;
  bool done_ = false;
};

}  // namespace dynemo::backend
