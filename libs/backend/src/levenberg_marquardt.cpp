#include "levenberg_marquardt.h"

#include <algorithm>
#include <cmath>

#include "problem.h"
#include "stopwatch.h"

namespace dynemo::backend {
namespace {

constexpr double kMinLambda = 1e-12;
constexpr double kMaxLambda = 1e12;
/// The least damping that visibly bends a step; where a rejection starts.
constexpr double kFirstRaisedLambda = 1e-4;
/// With more damping than this a small decrease says little about the distance to the minimum.
constexpr double kNearlyUndamped = 1e-3;
/// The factor is tried again where its step has lowered the cost by less than this share: after a
/// longer one the Hessian has become another.
constexpr double kShortStep = 1e-2;
/// The old factor stays in use while the predicted decrease falls by this factor from step to step.
constexpr double kFastContraction = 0.05;
/// Relative rounding error of the sum of squares.
constexpr double kCostRounding = 1e-14;

/// Σ ρ' JᵀΩe at the linearisation.
void gradientOf(LiveProblem& problem, std::vector<double>& gradient) {
  gradient.assign(static_cast<std::size_t>(problem.tangentSize()), 0.0);
  WhitenedFactor work;
  for (int f = 0; f < problem.factors(); ++f) {
    problem.prefetch(f + LiveProblem::kAhead);
    problem.linearize(f, work);
    const auto variables = problem.variablesOf(f);
    for (std::size_t i = 0; i < variables.size(); ++i) {
      double* const g = gradient.data() + problem.tangentOffset(variables[i]);
      for (int c = 0; c < problem.tangentSize(variables[i]); ++c)
        g[c] += work.J[i].col(c).dot(work.e);
    }
  }
}

/// The first factor whose cost at the estimate is not finite, or −1.
int firstNonFinite(LiveProblem& problem) {
  for (int f = 0; f < problem.factors(); ++f) {
    problem.updateCost(f);
    if (!std::isfinite(problem.cost(f))) return f;
  }
  return -1;
}

int costliest(LiveProblem& problem) {
  int worst = 0;
  for (int f = 0; f < problem.factors(); ++f) {
    problem.updateCost(f);
    if (problem.cost(f) > problem.cost(worst)) worst = f;
  }
  return worst;
}

}  // namespace

void LevenbergMarquardt::run() {
  bool started = false;
  while (true) {
    if (report_.iterations >= params_.max_iterations) return stop(StopReason::kMaxIterations);
    const bool factorized = factorizeDamped();
    if (!started) {
      // The linearisation has told the cost, as far as it came.
      cost_ = factorized ? problem_.linearizedCost() : costHere();
      report_.cost_before = report_.cost_after = cost_;
      if (!std::isfinite(cost_)) return fail();
      started = true;
    }
    const Trial trial = factorized ? tryStep() : Trial::kFailed;
    if (trial != Trial::kAccepted) problem_.discardSteps();
    if (done_) return;
    if (trial == Trial::kAccepted) {
      if (finishWithOldFactor()) return;
    } else if (!raiseDamping()) {
      // A finite step that only fails to lower the cost means that the estimate is as good as
      // rounding allows.
      if (trial == Trial::kRejected) return stop(StopReason::kNoDecrease);
      return fail();
    }
  }
}

bool LevenbergMarquardt::factorizeDamped() {
  const PhaseTimer timer(report_.numeric_ms);
  factor_.setDamping(lambda_);
  factor_.tree().touchAll();
  ++report_.factorizations;
  failed_variable_ = factor_.factorize(problem_);
  return !failed_variable_ && std::isfinite(factor_.modelDecrease());
}

double LevenbergMarquardt::predictedDecrease() const {
  // F(x) − [F + gᵀd + ½ dᵀHd] with (H + λD) d = −g.
  const double* const d = problem_.delta(0);
  double damping = 0.0;
  for (int i = 0; i < problem_.tangentSize(); ++i) damping += factor_.scale()[i] * d[i] * d[i];
  return factor_.modelDecrease() + 0.5 * lambda_ * damping;
}

LevenbergMarquardt::Trial LevenbergMarquardt::tryStep() {
  {
    const PhaseTimer timer(report_.solve_ms);
    factor_.solve(problem_, 0.0);
  }
  double largest = 0.0;
  for (int i = 0; i < problem_.tangentSize(); ++i) {
    const double d = std::abs(problem_.delta(0)[i]);
    if (!std::isfinite(d)) return Trial::kFailed;
    largest = std::max(largest, d);
  }
  predicted_ = predictedDecrease();
  const bool tiny = largest <= params_.min_step;
  if (predicted_ <= kCostRounding * cost_ || tiny) {
    done_ = true;
    stop(tiny ? StopReason::kSmallStep : StopReason::kConverged);
    return Trial::kRejected;
  }
  const double new_cost = tryCost();
  if (!std::isfinite(new_cost)) return Trial::kFailed;
  decrease_ = cost_ - new_cost;
  if (decrease_ < 0.0) return Trial::kRejected;
  lowerDamping(decrease_ / predicted_);
  if (decrease_ <= params_.min_relative_decrease * cost_ && lambda_ <= kNearlyUndamped) {
    done_ = true;
    stop(StopReason::kConverged);
  }
  accept(new_cost);
  return Trial::kAccepted;
}

void LevenbergMarquardt::accept(double cost) {
  for (int v = 0; v < problem_.variables(); ++v) problem_.relinearize(v);
  cost_ = report_.cost_after = cost;
  ++report_.iterations;
}

bool LevenbergMarquardt::raiseDamping() {
  lambda_ = std::max(lambda_ * raise_, kFirstRaisedLambda);
  raise_ *= 2.0;
  return lambda_ <= kMaxLambda;
}

void LevenbergMarquardt::lowerDamping(double gain_ratio) {
  const double bend = 2.0 * gain_ratio - 1.0;
  lambda_ = std::max(kMinLambda, lambda_ * std::clamp(1.0 - bend * bend * bend, 0.1, 2.0));
  raise_ = 2.0;
}

double LevenbergMarquardt::costHere() {
  problem_.updateCosts();
  return problem_.cost();
}

double LevenbergMarquardt::tryCost() {
  const PhaseTimer timer(report_.linearize_ms);
  for (int v = 0; v < problem_.variables(); ++v) problem_.updateEstimate(v);
  return costHere();
}

void LevenbergMarquardt::solveAgain() {
  {
    const PhaseTimer timer(report_.linearize_ms);
    gradientOf(problem_, gradient_);
  }
  const PhaseTimer timer(report_.solve_ms);
  factor_.solve(problem_, gradient_);
}

bool LevenbergMarquardt::finishWithOldFactor() {
  if (lambda_ > kNearlyUndamped || decrease_ < 0.5 * predicted_) return false;
  if (decrease_ > kShortStep * cost_) return false;
  double last_predicted = predicted_;
  while (report_.iterations < params_.max_iterations) {
    solveAgain();
    const double predicted = factor_.modelDecrease();
    const bool last_step = predicted <= params_.min_relative_decrease * cost_;
    if (!last_step && !(predicted <= kFastContraction * last_predicted)) break;
    const double cost = tryCost();
    const bool lower = cost <= cost_;
    if (lower) accept(cost);
    if (last_step) {
      problem_.discardSteps();
      stop(StopReason::kConverged);
      return true;
    }
    if (!lower) break;
    last_predicted = predicted;
  }
  problem_.discardSteps();
  return false;
}

void LevenbergMarquardt::fail() {
  stop(StopReason::kNumericalFailure);
  const auto edge = [this](int f) { return describe(*problem_.edge(f)); };
  if (const int f = firstNonFinite(problem_); f >= 0) {
    report_.message = edge(f) + " has a cost that is not finite";
  } else if (!gradientIsFinite()) {
    report_.message =
        edge(costliest(problem_)) + " is the costliest where the gradient is not finite";
  } else if (failed_variable_) {
    report_.message = describe(*problem_.node(*failed_variable_)) +
                      " makes the normal equations indefinite at every damping";
  } else {
    report_.message = "no step could be computed; the costliest is " + edge(costliest(problem_));
  }
}

bool LevenbergMarquardt::gradientIsFinite() {
  gradientOf(problem_, gradient_);
  return std::all_of(gradient_.begin(), gradient_.end(), [](double g) { return std::isfinite(g); });
}

}  // namespace dynemo::backend
