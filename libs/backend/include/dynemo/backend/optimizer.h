// Sparse non-linear least squares over a scene graph: Levenberg–Marquardt in batch, or one step at a time over what
// changed.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dynemo/core/error.h"
#include "dynemo/core/fields.h"
#include "dynemo/core/noise.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo {

struct SolverParams {
  enum class Method {
    kBatch,        ///< everything at every call, to convergence
    kIncremental,  ///< one step over what the change touches
    kWindowed      ///< the newest keyframes at once, the whole map on a second thread
  } method = Method::kIncremental;
  int max_iterations = 50;
  /// Stop when an accepted step lowers the cost by less than this fraction.
  double min_relative_decrease = 1e-6;
  /// Stop when no tangent entry moves by more than this [m, rad].
  double min_step = 1e-9;
  double initial_lambda = 1e-6;
  /// Incremental: way after which a node's edges are evaluated anew [m, rad].
  double relinearize_above = 0.03;
  /// Incremental: changes are not carried on whose neglect costs less than this share of the cost, all together.
  double neglected_share = 3e-4;
  /// Windowed: the most keyframes that are answered before the whole map has been.
  int window_keyframes = 40;
  /// Windowed: whether the whole map is solved on a thread of its own. The results are the same.
  bool second_thread = true;
};
void fields(FieldVisitor& v, SolverParams& p);

enum class StopReason { kNothingToDo, kConverged, kSmallStep, kMaxIterations, kNoDecrease, kNumericalFailure };
const char* stopReasonName(StopReason reason);

/// What one optimisation did; born pessimistic.
struct OptimizationReport {
  StopReason stop = StopReason::kNumericalFailure;
  int iterations = 0;           ///< accepted steps
  int factorizations = 0;
  double cost_before = 0.0, cost_after = 0.0;  ///< F = ½ Σ ρ(eᵀΩe)
  std::size_t nodes = 0, edges = 0, tangent_size = 0;
  /// Of the processor, in the thread that called: the phases, and all.
  double ordering_ms = 0, symbolic_ms = 0, linearize_ms = 0, numeric_ms = 0, solve_ms = 0, cpu_ms = 0;
  double total_ms = 0;          ///< on the wall
  std::string message;          ///< why it failed, naming the node or edge; empty otherwise
  bool usable() const { return stop != StopReason::kNumericalFailure; }
};

/// Keeps what it can between calls (ordering, factorisation). Not thread-safe; use one per graph.
class Optimizer {
 public:
  explicit Optimizer(const SolverParams& params);
  ~Optimizer();
  Optimizer(Optimizer&&) noexcept;
  Optimizer& operator=(Optimizer&&) noexcept;

  /// Lowers the graph's cost from its current estimates, by the method of the parameters, and writes the result
  /// back; on failure the estimates stay as they were. (By the other methods than batch the cost may rise by what is neglected.) Nodes without edges are left alone; a free gauge is held by
  /// the damping. An edge that was there at an earlier call must not have changed since: replace it instead.
  OptimizationReport optimize(CSceneGraph& graph);
  /// The same in batch, to convergence, whatever the method.
  OptimizationReport optimizeFully(CSceneGraph& graph);

  /// Joint marginal covariance of the nodes' tangents at the current estimates (incremental, windowed: at the
  /// linearisation that the last step used), stacked in the order given. The failure says why, e.g. that the gauge is
  /// free.
  Expected<MatrixX, std::string> marginalCovariance(const CSceneGraph& graph, std::span<const NodeId> nodes);

  /// The diagonal blocks only, for many nodes at once, in the order given.
  Expected<std::vector<MatrixX>, std::string> marginalBlocks(const CSceneGraph& graph, std::span<const NodeId> nodes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynemo
