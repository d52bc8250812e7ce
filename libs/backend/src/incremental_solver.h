// One exact step per change of the graph: only what the change touches is linearised, factorised
// and solved again.
//
// The normal equations are those of the linearisation points x₀, and the estimate is x₀ ⊞ δ with
// the minimiser δ. The factors of a variable that has moved by more than `relinearize_above`, and
// those whose robust weights have changed, are evaluated anew: as a correction of the right-hand
// side, which costs a substitution along their paths; as a new linearisation, which dirties their
// fronts, where these are dirty anyhow, where the Hessian has become another, or where corrections
// do not close in on the minimum. When the true cost differs from the quadratic model's, another
// step follows at once. The elimination order is renewed, and everything linearised anew, when the
// steps since the last renewal have become dear enough to pay for it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "front_factor.h"
#include "live_problem.h"
#include "local_start.h"

namespace dynemo::backend {

class IncrementalSolver {
 public:
  explicit IncrementalSolver(const SolverParams& params) : params_(params), start_(params) {}

  /// Takes over nodes and edges that came and went, and the current estimates of the nodes in
  /// `moved`, which somebody else has changed. Reads the graph; solve() does not. True when most of
  /// the graph has come since the last restart or solution.
  bool synchronize(const CSceneGraph& graph, std::span<const NodeId> moved);
  /// Forgets everything and starts from the graph as it is, which somebody else has solved.
  void restart(const CSceneGraph& graph);

  /// Makes a fresh elimination order when one is due; solve() would. METIS draws from the C
  /// library's random numbers, so a solve() on another thread wants this done before, on the
  /// caller's.
  void prepare(OptimizationReport& report);
  /// One step, more when the cost asks for it. False when there is no solution to be had this way
  /// (a free gauge, a cost that is not finite or that rises): restart() is then due.
  bool solve(OptimizationReport& report);

  /// Whether every edge that the solver knows is still in the graph.
  bool isPartOf(const CSceneGraph& graph);

  const LiveProblem& problem() const { return problem_; }
  const FrontFactor& factor() const { return factor_; }
  /// Of the variables that are alive.
  std::size_t nodes() const;
  std::size_t tangentSize() const;
  /// Variables whose estimate solve() changed.
  std::span<const int> changed() const { return changed_; }
  /// Brings the factorisation up to the last synchronisation without a step. False when the system
  /// is singular.
  bool factorize();

 private:
  void reset();
  /// The last one that is still there; −1 when there is none.
  int newestFactor() const;
  void forgetMissing(const CSceneGraph& graph);
  void removeMissing(const CSceneGraph& graph);
  void addNew(const CSceneGraph& graph);
  void takeState(int variable);
  bool renewalIsDue() const;
  void account(double work);
  void orderAnew();
  void renew();
  void attendToPending();
  bool isFar(int variable) const;
  void correct(int factor);
  void relinearize(int variable);
  void takeStep(int variable);
  void touchCost(int factor);
  void updateCosts();
  /// Brings model and factorisation up to what has changed; false when they break down.
  bool updateModel(OptimizationReport& report);
  double neglectedDeviations() const;
  /// Goes to the model's minimum.
  void step(OptimizationReport& report);

  SolverParams params_;
  std::size_t known_edges_ = 0;    ///< slots of the graph that have been looked at
  std::size_t removed_edges_ = 0;  ///< of the graph, in all its life, when it was last looked at
  CholmodContext context_;
  LiveProblem problem_;
  FrontFactor factor_;
  LocalStart start_;
  std::vector<int> new_;                    ///< variables that no step has seen
  std::optional<Elimination> fresh_order_;  ///< for the next renewal
  bool needs_build_ = true, renewed_ = false, mostly_new_ = false;

  std::vector<int> pending_, stale_;  ///< variables, factors that want to be evaluated anew
  std::vector<char> is_pending_, is_stale_;
  bool insists_ = false;       ///< on new linearisations of all that is pending
  std::vector<double> drift_;  ///< per variable, way since its factors were evaluated [m, rad]
  std::vector<int> changed_, costs_, corrections_;
  std::vector<char> is_changed_, is_cost_, is_correction_;
  std::vector<char> is_dirty_;  ///< per front
  std::vector<double> state_;

  // Work since the order was renewed [flop].
  std::vector<double> work_;
  double renewal_work_ = 0.0;
  double fresh_flops_ = 0.0;   ///< of the whole tree, per variable
  double work_on_fill_ = 0.0;  ///< what steps took for fill that has come since
};

}  // namespace dynemo::backend
