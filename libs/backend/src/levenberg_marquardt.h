// Levenberg–Marquardt over all of a problem.
//
// A step solves (H + λ D) d = −g, D a positive diagonal. λ starts almost at zero, so that from a
// warm start the first step is a Gauss–Newton step, and follows the gain ratio (Nielsen, "Damping
// parameter in Marquardt's method", 1999). After an accepted step the old factor is used again on
// the new gradient for as long as that contracts fast (the simplified Newton method): the
// factorisations that would only confirm the minimum are saved.
#pragma once

#include "dynemo/backend/optimizer.h"
#include "front_factor.h"
#include "live_problem.h"

namespace dynemo::backend {

class LevenbergMarquardt {
 public:
  /// The factor has been built for the problem.
  LevenbergMarquardt(const SolverParams& params, LiveProblem& problem, FrontFactor& factor,
                     OptimizationReport& report)
      : params_(params),
        problem_(problem),
        factor_(factor),
        report_(report),
        lambda_(params.initial_lambda) {}

  /// Minimises from the problem's estimates, which end at the best ones found. Fills the report.
  void run();

 private:
  enum class Trial { kAccepted, kRejected, kFailed };

  bool factorizeDamped();
  /// −½ gᵀd of the undamped model.
  double predictedDecrease() const;
  Trial tryStep();
  void accept(double cost);
  /// Raises λ; false when there is no more room.
  bool raiseDamping();
  void lowerDamping(double gain_ratio);
  /// Steps with the factor of an earlier linearisation; true when they reached the minimum.
  bool finishWithOldFactor();
  /// The step from the gradient at the estimate with the factor as it is.
  void solveAgain();
  /// Cost at the estimate.
  double costHere();
  /// Cost at the estimate ⊞ step, which becomes the estimate.
  double tryCost();
  bool gradientIsFinite();
  void stop(StopReason reason) { report_.stop = reason; }
  void fail();

  const SolverParams& params_;
  LiveProblem& problem_;
  FrontFactor& factor_;
  OptimizationReport& report_;

  std::vector<double> gradient_;
  double cost_ = 0.0, lambda_, raise_ = 2.0;
  double predicted_ = 0.0, decrease_ = 0.0;
  std::optional<int> failed_variable_;
  bool done_ = false;
};

}  // namespace dynemo::backend
