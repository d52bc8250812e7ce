#include "dynemo/backend/optimizer.h"

#include <optional>

#include "levenberg_marquardt.h"
#include "marginals.h"
#include "stopwatch.h"

namespace dynemo {

using namespace backend;

struct Optimizer::Impl {
  /// What depends on the connectivity only.
  struct Analysis {
    Connectivity connectivity;
    BlockStructure structure;
    SparseFactor factor;
  };

  SolverParams params;
  CholmodContext context;
  std::optional<Analysis> analysis;

  /// Reuses the last analysis when nothing but numbers changed.
  Analysis& analyze(const Problem& problem, double& ordering_ms, double& symbolic_ms) {
    if (analysis && analysis->connectivity == problem.connectivity()) return *analysis;
    std::optional<BlockStructure> structure;
    {
      const ScopedTimer timer(ordering_ms);
      Adjacency adjacency = adjacencyOf(problem.connectivity());
      std::vector<int> order = eliminationOrder(adjacency, context);
      structure.emplace(problem.connectivity(), adjacency, std::move(order));
    }
    const ScopedTimer timer(symbolic_ms);
    SparseFactor factor(*structure, context);
    analysis.emplace(Analysis{problem.connectivity(), std::move(*structure), std::move(factor)});
    return *analysis;
  }

  void optimize(CSceneGraph& graph, OptimizationReport& report);
};

namespace {

Expected<std::vector<int>, std::string> variablesOf(const Problem& problem,
                                                    std::span<const NodeId> nodes) {
  std::vector<int> variables;
  for (const NodeId node : nodes) {
    variables.push_back(problem.variableOf(node));
    if (variables.back() < 0) {
      return make_unexpected("node " + std::to_string(node.value) +
                             " has no edge, so nothing is known about it");
    }
  }
  return variables;
}

}  // namespace

Optimizer::Optimizer(const SolverParams& params) : impl_(std::make_unique<Impl>()) {
  impl_->params = params;
}
Optimizer::~Optimizer() = default;
Optimizer::Optimizer(Optimizer&&) noexcept = default;
Optimizer& Optimizer::operator=(Optimizer&&) noexcept = default;

void Optimizer::Impl::optimize(CSceneGraph& graph, OptimizationReport& report) {
  const ScopedTimer timer(report.total_ms);
  const Problem problem(graph);
  report.nodes = static_cast<std::size_t>(problem.connectivity().variables());
  report.edges = static_cast<std::size_t>(problem.connectivity().factors());
  report.tangent_size = problem.tangentSize();
  if (report.edges == 0) {
    report.stop = StopReason::kNothingToDo;
    return;
  }
  Analysis& a = analyze(problem, report.ordering_ms, report.symbolic_ms);
  std::vector<double> states = problem.readStates();
  LevenbergMarquardt(params, problem, a.structure, a.factor, report).run(states);
  if (!report.usable() || report.iterations == 0) return;
  for (int v = 0; v < problem.connectivity().variables(); ++v) {
    graph.setState(problem.node(v).id, &states[problem.stateOffset(v)]);
  }
}

OptimizationReport Optimizer::optimize(CSceneGraph& graph) {
  OptimizationReport report;
  impl_->optimize(graph, report);
  return report;
}

Expected<MatrixX, std::string> Optimizer::marginalCovariance(const CSceneGraph& graph,
                                                             std::span<const NodeId> nodes) {
  const Problem problem(graph);
  const auto variables = variablesOf(problem, nodes);
  if (!variables) return make_unexpected(variables.error());
  if (variables->empty()) return MatrixX(0, 0);
  double ignored_ms = 0.0;
  Impl::Analysis& a = impl_->analyze(problem, ignored_ms, ignored_ms);
  if (const auto failure = factorizeUndamped(problem, a.structure, a.factor))
    return make_unexpected(*failure);
  return jointCovariance(problem, a.structure, a.factor, *variables);
}

Expected<std::vector<MatrixX>, std::string> Optimizer::marginalBlocks(
    const CSceneGraph& graph, std::span<const NodeId> nodes) {
  const Problem problem(graph);
  const auto variables = variablesOf(problem, nodes);
  if (!variables) return make_unexpected(variables.error());
  if (variables->empty()) return std::vector<MatrixX>{};
  double ignored_ms = 0.0;
  Impl::Analysis& a = impl_->analyze(problem, ignored_ms, ignored_ms);
  // A simplicial factor has no supernodes to run over.
  SparseFactor supernodal(a.structure, impl_->context, SparseFactor::Kind::kSupernodal);
  if (const auto failure = factorizeUndamped(problem, a.structure, supernodal))
    return make_unexpected(*failure);
  return blockCovariances(problem, a.structure, supernodal, *variables);
}

}  // namespace dynemo
