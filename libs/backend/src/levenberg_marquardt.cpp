#include "levenberg_marquardt.h"

#include <algorithm>
#include <cmath>

#include "stopwatch.h"

namespace dynemo::backend {
namespace {

constexpr double kMinLambda = 1e-12;
constexpr double kMaxLambda = 1e12;
/// The least damping that visibly bends a step; where a rejection starts.
constexpr double kFirstRaisedLambda = 1e-4;
/// With more damping than this a small decrease says little about the distance to the minimum.
constexpr double kNearlyUndamped = 1e-3;
/// The old factor stays in use while the predicted decrease falls by this factor from step to step.
constexpr double kFastContraction = 0.05;
/// Keeps directions that no residual sees from making the system singular.
constexpr double kMinScale = 1e-6;
/// Relative rounding error of the sum of squares.
constexpr double kCostRounding = 1e-14;

}  // namespace

LevenbergMarquardt::LevenbergMarquardt(const SolverParams& params, const Problem& problem,
                                       const BlockStructure& structure, SparseFactor& factor,
                                       OptimizationReport& report)
    : params_(params),
      problem_(problem),
      structure_(structure),
      factor_(factor),
      report_(report),
      scale_(structure.size()),
      lambda_(params.initial_lambda) {}

void LevenbergMarquardt::run(std::vector<double>& states) {
  linearizeAt(states);
  report_.cost_before = report_.cost_after = equations_.cost;
  if (!std::isfinite(equations_.cost) || !equations_.gradient.allFinite()) return fail(states);
  while (true) {
    if (report_.iterations >= params_.max_iterations) return stop(StopReason::kMaxIterations);
    const Trial trial = tryStep(states);
    if (done_) return;
    if (trial == Trial::kAccepted) {
      linearizeAt(states);
      if (finishWithOldFactor(states)) return;
    } else if (!raiseDamping()) {
      // A finite step that only fails to lower the cost means that the estimate is as good as
      // rounding allows.
      if (trial == Trial::kRejected) return stop(StopReason::kNoDecrease);
      return fail(states);
    }
  }
}

void LevenbergMarquardt::linearizeAt(const std::vector<double>& states) {
  const PhaseTimer timer(report_.linearize_ms);
  linearize(problem_, structure_, states, equations_);
  scaleDamping();
}

void LevenbergMarquardt::scaleDamping() {
  // One scale for the three axes of a translation and one for those of a rotation: single entries
  // of the diagonal would make the step depend on how the pose's own axes happen to lie.
  constexpr int kAxes = 3;
  for (int v = 0; v < problem_.connectivity().variables(); ++v) {
    const int begin = structure_.tangentOffset(v),
              end = begin + problem_.connectivity().tangent_size[v];
    for (int first = begin; first < end; first += kAxes) {
      const int count = std::min(kAxes, end - first);
      double sum = 0.0;
      for (int i = first; i < first + count; ++i)
        sum += equations_.hessian[structure_.diagonal()[i]];
      scale_.segment(first, count).setConstant(std::max(sum / count, kMinScale));
    }
  }
}

bool LevenbergMarquardt::factorizeDamped() {
  const PhaseTimer timer(report_.numeric_ms);
  const auto& diagonal = structure_.diagonal();
  VectorX undamped(structure_.size());
  for (int i = 0; i < structure_.size(); ++i) {
    double& h = equations_.hessian[diagonal[i]];
    undamped[i] = h;
    h += lambda_ * scale_[i];
  }
  const auto bad_pivot = factor_.factorize(structure_, equations_.hessian);
  for (int i = 0; i < structure_.size(); ++i) equations_.hessian[diagonal[i]] = undamped[i];
  ++report_.factorizations;
  failed_pivot_ = bad_pivot.value_or(-1);
  return !bad_pivot;
}

void LevenbergMarquardt::solveStep() {
  const PhaseTimer timer(report_.solve_ms);
  negative_gradient_ = -equations_.gradient;
  factor_.solve(negative_gradient_, step_);
}

LevenbergMarquardt::Trial LevenbergMarquardt::tryStep(std::vector<double>& states) {
  if (!factorizeDamped()) return Trial::kFailed;
  solveStep();
  if (!step_.allFinite()) return Trial::kFailed;
  // F(x) − [F + gᵀd + ½ dᵀHd] with (H + λD) d = −g.
  predicted_ = 0.5 * step_.dot(lambda_ * scale_.cwiseProduct(step_) - equations_.gradient);
  const double cost = equations_.cost;
  const bool at_rounding = predicted_ <= kCostRounding * cost;
  const bool tiny = step_.lpNorm<Eigen::Infinity>() <= params_.min_step;
  if (at_rounding || tiny) {
    done_ = true;
    stop(tiny ? StopReason::kSmallStep : StopReason::kConverged);
    return Trial::kRejected;
  }
  const double new_cost = tryCost(states);
  if (!std::isfinite(new_cost)) return Trial::kFailed;
  decrease_ = cost - new_cost;
  if (decrease_ < 0.0) return Trial::kRejected;
  accept(states, new_cost);
  lowerDamping(decrease_ / predicted_);
  if (decrease_ <= params_.min_relative_decrease * cost && lambda_ <= kNearlyUndamped) {
    done_ = true;
    stop(StopReason::kConverged);
  }
  return Trial::kAccepted;
}

void LevenbergMarquardt::accept(std::vector<double>& states, double cost) {
  states.swap(candidate_);
  report_.cost_after = cost;
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

double LevenbergMarquardt::tryCost(const std::vector<double>& states) {
  const PhaseTimer timer(report_.linearize_ms);
  retract(problem_, structure_, states, step_, candidate_);
  return evaluateCost(problem_, candidate_);
}

bool LevenbergMarquardt::finishWithOldFactor(std::vector<double>& states) {
  if (lambda_ > kNearlyUndamped || decrease_ < 0.5 * predicted_) return false;
  double last_predicted = predicted_;
  while (report_.iterations < params_.max_iterations) {
    solveStep();
    const double predicted = -0.5 * step_.dot(equations_.gradient);
    const bool last_step = predicted <= params_.min_relative_decrease * equations_.cost;
    if (!last_step && !(predicted <= kFastContraction * last_predicted)) return false;
    const double cost = tryCost(states);
    const bool lower = cost <= equations_.cost;
    if (lower) accept(states, cost);
    if (last_step) {
      stop(StopReason::kConverged);
      return true;
    }
    if (!lower) return false;
    linearizeAt(states);
    last_predicted = predicted;
  }
  return false;
}

void LevenbergMarquardt::fail(const std::vector<double>& states) {
  stop(StopReason::kNumericalFailure);
  if (const int f = firstNonFiniteFactor(problem_, states); f >= 0) {
    report_.message = problem_.describeFactor(f) + " has a cost that is not finite";
  } else if (!equations_.gradient.allFinite()) {
    report_.message = problem_.describeFactor(costliestFactor(problem_, states)) +
                      " is the costliest where the gradient is not finite";
  } else if (failed_pivot_ >= 0) {
    report_.message = problem_.describeVariable(structure_.variableAt(failed_pivot_)) +
                      " makes the normal equations indefinite at every damping";
  } else if (const int g = firstNonFiniteFactor(problem_, candidate_); g >= 0) {
    report_.message = "every step makes the cost of " + problem_.describeFactor(g) + " not finite";
  } else {
    report_.message = "no step could be computed; the costliest is " +
                      problem_.describeFactor(costliestFactor(problem_, states));
  }
}

}  // namespace dynemo::backend
