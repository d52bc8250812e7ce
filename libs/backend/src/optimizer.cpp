#include "dynemo/backend/optimizer.h"

#include <optional>

#include "front_marginals.h"
#include "incremental_solver.h"
#include "levenberg_marquardt.h"
#include "marginals.h"
#include "state_watch.h"
#include "stopwatch.h"
#include "windowed_solver.h"

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
  KeptOrder kept_order;
  std::optional<Analysis> analysis;
  /// Of the batch method.
  Connectivity batch_connectivity;
  LiveProblem batch_problem;
  FrontFactor batch_factor;
  IncrementalSolver incremental;
  StateWatch watch;

  WindowedSolver windowed;

  explicit Impl(const SolverParams& p) : params(p), incremental(p), windowed(p) {}

  /// Reuses the last analysis when nothing but numbers changed.
  Analysis& analyze(const Problem& problem, double& ordering_ms, double& symbolic_ms) {
    if (analysis && analysis->connectivity == problem.connectivity()) return *analysis;
    std::optional<BlockStructure> structure;
    {
      const PhaseTimer timer(ordering_ms);
      Adjacency adjacency = adjacencyOf(problem.connectivity());
      structure.emplace(problem.connectivity(), adjacency,
                        kept_order.update(problem, adjacency, context).order);
    }
    const PhaseTimer timer(symbolic_ms);
    SparseFactor factor(*structure, context);
    analysis.emplace(Analysis{problem.connectivity(), std::move(*structure), std::move(factor)});
    return *analysis;
  }

  /// The elimination tree of the batch method, the last one when nothing but numbers changed.
  void layOut(const Problem& problem, const LiveProblem& live, OptimizationReport& report) {
    if (batch_connectivity == problem.connectivity()) return;
    Elimination elimination;
    {
      const PhaseTimer timer(report.ordering_ms);
      Adjacency adjacency = adjacencyOf(problem.connectivity());
      elimination.order = kept_order.update(problem, adjacency, context).order;
    }
    const PhaseTimer timer(report.symbolic_ms);
    batch_factor.keepUpdates(false);
    batch_factor.build(live, elimination, context);
    batch_connectivity = problem.connectivity();
  }

  /// Brings the problem of the batch method up to the graph, numbered as in `problem`.
  void follow(const CSceneGraph& graph, const Problem& problem);
  void optimizeInBatch(CSceneGraph& graph, OptimizationReport& report);
  void optimizeIncrementally(CSceneGraph& graph, OptimizationReport& report);
  void optimizeInWindow(CSceneGraph& graph, OptimizationReport& report);
  /// Brings the incremental factorisation up to the graph as it stands; false when there is none.
  bool isFactorized(const CSceneGraph& graph);
};

namespace {

template <class AnyProblem>
Expected<std::vector<int>, std::string> variablesOf(const AnyProblem& problem,
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

Optimizer::Optimizer(const SolverParams& params) : impl_(std::make_unique<Impl>(params)) {}
Optimizer::~Optimizer() = default;
Optimizer::Optimizer(Optimizer&&) noexcept = default;
Optimizer& Optimizer::operator=(Optimizer&&) noexcept = default;

void Optimizer::Impl::follow(const CSceneGraph& graph, const Problem& problem) {
  const int variables = problem.connectivity().variables(),
            factors = problem.connectivity().factors();
  LiveProblem& live = batch_problem;
  bool extends = live.variables() <= variables && live.factors() <= factors;
  for (int v = 0; extends && v < live.variables(); ++v)
    extends = live.node(v).get() == &problem.node(v);
  for (int f = 0; extends && f < live.factors(); ++f)
    extends = live.edge(f).get() == &problem.edge(f);
  if (!extends) live = {};
  std::vector<double> state;
  for (int v = 0; v < live.variables(); ++v) {
    state.resize(static_cast<std::size_t>(problem.node(v).stateSize()));
    problem.node(v).readState(state.data());
    live.setState(v, state.data());
  }
  for (int v = live.variables(); v < variables; ++v)
    live.addVariable(graph.nodeSlots()[problem.node(v).id.value]);
  for (int f = live.factors(); f < factors; ++f)
    live.addFactor(graph.edgeSlots()[problem.edge(f).id.value]);
}

void Optimizer::Impl::optimizeInBatch(CSceneGraph& graph, OptimizationReport& report) {
  const Problem problem(graph);
  report.nodes = static_cast<std::size_t>(problem.connectivity().variables());
  report.edges = static_cast<std::size_t>(problem.connectivity().factors());
  report.tangent_size = problem.tangentSize();
  if (report.edges == 0) {
    report.stop = StopReason::kNothingToDo;
    return;
  }
  follow(graph, problem);
  const SingleThreaded single_threaded;
  layOut(problem, batch_problem, report);
  LevenbergMarquardt(params, batch_problem, batch_factor, report).run();
  if (report.usable() && report.iterations > 0) {
    for (int v = 0; v < batch_problem.variables(); ++v)
      graph.setState(batch_problem.node(v)->id, batch_problem.estimate(v));
  }
  // Methods that solve in batch now and then need not hold a second factorisation meanwhile.
  if (params.method == SolverParams::Method::kBatch) return;
  batch_problem = {};
  batch_factor = {};
  batch_connectivity = {};
}

void Optimizer::Impl::optimizeIncrementally(CSceneGraph& graph, OptimizationReport& report) {
  // A graph that is mostly new has no warm start worth the name.
  const bool mostly_new = incremental.synchronize(graph, watch.moved(graph));
  if (graph.edgeCount() == 0) {
    report.stop = StopReason::kNothingToDo;
    return;
  }
  if (mostly_new || !incremental.solve(report)) {
    report = {};
    optimizeInBatch(graph, report);
    incremental.restart(graph);
    watch.moved(graph);
    return;
  }
  const LiveProblem& problem = incremental.problem();
  report.nodes = incremental.nodes();
  report.edges = graph.edgeCount();
  report.tangent_size = incremental.tangentSize();
  for (const int v : incremental.changed()) {
    if (!problem.alive(v)) continue;
    graph.setState(problem.node(v)->id, problem.estimate(v));
    watch.record(*problem.node(v));
  }
}

void Optimizer::Impl::optimizeInWindow(CSceneGraph& graph, OptimizationReport& report) {
  if (windowed.solve(graph, report)) return;
  report = {};
  optimizeInBatch(graph, report);
  if (report.usable()) windowed.restart(graph);
}

bool Optimizer::Impl::isFactorized(const CSceneGraph& graph) {
  if (params.method != SolverParams::Method::kIncremental) return false;
  incremental.synchronize(graph, watch.moved(graph));
  return incremental.factorize();
}

OptimizationReport Optimizer::optimize(CSceneGraph& graph) {
  OptimizationReport report;
  const WallTimer timer(report.total_ms);
  const PhaseTimer cpu_timer(report.cpu_ms);
  switch (impl_->params.method) {
    case SolverParams::Method::kBatch:
      impl_->optimizeInBatch(graph, report);
      break;
    case SolverParams::Method::kIncremental:
      impl_->optimizeIncrementally(graph, report);
      break;
    case SolverParams::Method::kWindowed:
      impl_->optimizeInWindow(graph, report);
      break;
  }
  return report;
}

OptimizationReport Optimizer::optimizeFully(CSceneGraph& graph) {
  OptimizationReport report;
  const WallTimer timer(report.total_ms);
  const PhaseTimer cpu_timer(report.cpu_ms);
  impl_->optimizeInBatch(graph, report);
  if (impl_->params.method == SolverParams::Method::kWindowed && report.usable())
    impl_->windowed.restart(graph);
  return report;
}

Expected<MatrixX, std::string> Optimizer::marginalCovariance(const CSceneGraph& graph,
                                                             std::span<const NodeId> nodes) {
  if (impl_->isFactorized(graph)) {
    const LiveProblem& problem = impl_->incremental.problem();
    const auto variables = variablesOf(problem, nodes);
    if (!variables) return make_unexpected(variables.error());
    if (variables->empty()) return MatrixX(0, 0);
    return jointCovariance(problem, impl_->incremental.factor(), *variables);
  }
  MatrixX joint;
  if (impl_->params.method == SolverParams::Method::kWindowed &&
      impl_->windowed.covariance(graph, nodes, joint))
    return joint;
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
  if (impl_->isFactorized(graph)) {
    const LiveProblem& problem = impl_->incremental.problem();
    const auto variables = variablesOf(problem, nodes);
    if (!variables) return make_unexpected(variables.error());
    if (variables->empty()) return std::vector<MatrixX>{};
    return blockCovariances(problem, impl_->incremental.factor(), *variables);
  }
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
