// A better start for variables that have just come.
#pragma once

#include <span>

#include "dynemo/backend/optimizer.h"
#include "front_factor.h"
#include "live_problem.h"

namespace dynemo::backend {

/// Brings new variables to where their factors want them, with everything else held: the step over
/// the whole problem then starts from weights and linearisations that it need not revise.
class LocalStart {
 public:
  explicit LocalStart(const SolverParams& params);
  /// Where no better start is to be had the variables stay where they are.
  void run(LiveProblem& problem, std::span<const int> variables);

 private:
  SolverParams params_;
  CholmodContext context_;
  FrontFactor factor_;
};

}  // namespace dynemo::backend
