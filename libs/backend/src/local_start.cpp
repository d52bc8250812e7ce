#include "local_start.h"

#include "levenberg_marquardt.h"

namespace dynemo::backend {
namespace {

/// A start, not a solution.
constexpr int kSteps = 3;
constexpr double kRelativeDecrease = 1e-2;

}  // namespace

LocalStart::LocalStart(const SolverParams& params) : params_(params) {
  params_.max_iterations = kSteps;
  params_.min_relative_decrease = kRelativeDecrease;
  factor_.keepUpdates(false);
}

void LocalStart::run(LiveProblem& problem, std::span<const int> variables) {
  LiveProblem local;
  for (const int v : variables) local.addVariable(problem.node(v), problem.estimate(v));
  for (const int v : variables) {
    problem.forEachFactorOf(v, [&](int f) {
      if (local.factorOf(problem.edge(f)->id) >= 0) return;
      for (const int other : problem.variablesOf(f)) {
        const NodeId node = problem.node(other)->id;
        if (local.variableOf(node) < 0)
          local.addVariable(problem.node(other), problem.estimate(other), true);
      }
      local.addFactor(problem.edge(f));
    });
  }
  if (local.factors() == 0) return;
  factor_.build(local, context_);
  OptimizationReport report;
  LevenbergMarquardt(params_, local, factor_, report).run();
  if (!report.usable()) return;
  for (std::size_t i = 0; i < variables.size(); ++i)
    problem.setState(variables[i], local.estimate(static_cast<int>(i)));
}

}  // namespace dynemo::backend
