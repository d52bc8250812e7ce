#include "dynemo/backend/optimizer.h"

namespace dynemo {

void fields(FieldVisitor& v, SolverParams& p) {
  v.choice("method", p.method, {"batch", "incremental", "windowed"},
           "At every keyframe: the whole graph to convergence, one step over what changed, or the "
           "newest keyframes at once and the whole map on a second thread");
  v.integer("max_iterations", p.max_iterations, "Most accepted steps of one optimisation",
            {1, 10000});
  v.number("min_relative_decrease", p.min_relative_decrease,
           "Stop when a step lowers the cost by less than this fraction", Range::between(0.0, 0.1));
  v.number("min_step", p.min_step, "Stop when no tangent entry moves by more than this [m, rad]",
           Range::nonNegative());
  v.number("initial_lambda", p.initial_lambda,
           "First damping, relative to the diagonal of the normal equations",
           Range::between(1e-15, 1e3));
  v.number("relinearize_above", p.relinearize_above,
           "Incremental: way after which a node's edges are evaluated anew [m, rad]",
           Range::between(0.0, 0.1));
  v.number("neglected_share", p.neglected_share,
           "Incremental: changes are not carried on whose neglect costs less than this share of "
           "the cost, all together",
           Range::between(0.0, 1e-3));
  v.integer("window_keyframes", p.window_keyframes,
            "Windowed: the most keyframes that are answered before the whole map has been",
            {2, 1000});
  v.flag("second_thread", p.second_thread,
         "Windowed: solve the whole map on a thread of its own; the results are the same");
}

const char* stopReasonName(StopReason reason) {
  switch (reason) {
    case StopReason::kNothingToDo:
      return "nothing_to_do";
    case StopReason::kConverged:
      return "converged";
    case StopReason::kSmallStep:
      return "small_step";
    case StopReason::kMaxIterations:
      return "max_iterations";
    case StopReason::kNoDecrease:
      return "no_decrease";
    case StopReason::kNumericalFailure:
      break;
  }
  return "numerical_failure";
}

}  // namespace dynemo
