#include "two_tier_solver.h"

#include <algorithm>

namespace dynemo::backend {

void TwoTierSolver::wait() {
  if (running_.valid()) running_.wait();
}

void TwoTierSolver::restart(const CSceneGraph& graph) {
  wait();
  running_ = {};
  whole_.restart(graph);
  watch_.moved(graph);
  stale_.clear();
  started_ = true;
  calls_ = 0;
  merged_edges_ = begun_edges_ = graph.nextEdgeId();
  begun_nodes_ = graph.nextNodeId();
  if (!graph.keyframes().empty()) anchor_ = graph.keyframes().back()->id;
}

void TwoTierSolver::begin() {
  running_ = std::async(std::launch::async, [this] {
    OptimizationReport unused;
    return whole_.solve(unused);
  });
}

bool TwoTierSolver::solve(CSceneGraph& graph, OptimizationReport& report) {
  if (!started_) return false;
  if (++calls_ % params_.join_every == 0 && !join(graph, report)) return false;
  if (!window_.solve(graph, merged_edges_, report)) return false;
  for (const NodeId node : window_.written()) {
    if (node.value >= stale_.size()) stale_.resize(node.value + 1, 0);
    stale_[node.value] = 1;
    watch_.record(*graph.nodeSlots()[node.value],
                  window_.problem().estimate(window_.problem().variableOf(node)));
  }
  return true;
}

bool TwoTierSolver::join(CSceneGraph& graph, OptimizationReport& report) {
  const auto moved_span = watch_.moved(graph);
  const std::vector<NodeId> moved(moved_span.begin(), moved_span.end());
  if (running_.valid()) {
    if (!running_.get()) return false;
    merge(graph, moved);
    merged_edges_ = begun_edges_;
  }
  if (whole_.synchronize(graph, moved)) return false;
  begun_nodes_ = graph.nextNodeId();
  begun_edges_ = graph.nextEdgeId();
  anchor_ = graph.keyframes().back()->id;
  whole_.prepare(report);
  begin();
  return true;
}

void TwoTierSolver::write(CSceneGraph& graph, NodeId node, const double* state) {
  graph.setState(node, state);
  watch_.record(*graph.nodeSlots()[node.value], state);
}

void TwoTierSolver::merge(CSceneGraph& graph, std::span<const NodeId> moved) {
  const LiveProblem& problem = whole_.problem();
  const auto usable = [&](int v) {
    return v >= 0 && problem.alive(v) &&
           graph.nodeSlots()[problem.node(v)->id.value] == problem.node(v) &&
           !std::binary_search(moved.begin(), moved.end(), problem.node(v)->id);
  };
  // How far the solution moves the keyframe at its end.
  Pose3 T_map_before;
  const auto* anchor = graph.findNode<CNodePose>(anchor_);
  const int anchor_variable = problem.variableOf(anchor_);
  if (anchor && usable(anchor_variable)) {
    T_map_before =
        CNodePose::poseFromState(problem.estimate(anchor_variable)) * anchor->T_map_node.inverse();
  }
  for (const int v : whole_.changed())
    if (usable(v)) write(graph, problem.node(v)->id, problem.estimate(v));
  for (std::size_t i = 0; i < std::min<std::size_t>(stale_.size(), begun_nodes_.value); ++i) {
    const int v = stale_[i] ? problem.variableOf({i}) : -1;
    if (usable(v)) write(graph, {i}, problem.estimate(v));
  }
  std::fill(stale_.begin(), stale_.end(), 0);
  for (std::size_t i = begun_nodes_.value; i < graph.nodeSlots().size(); ++i) {
    const auto* pose = graph.findNode<CNodePose>({i});
    if (!pose || std::binary_search(moved.begin(), moved.end(), NodeId{i})) continue;
    double state[CNodePose::kStateSize];
    CNodePose::poseToState((T_map_before * pose->T_map_node).normalized(), state);
    write(graph, {i}, state);
  }
}

bool TwoTierSolver::windowKnows(const CSceneGraph& graph, std::span<const NodeId> nodes) const {
  const LiveProblem& problem = window_.problem();
  return std::all_of(nodes.begin(), nodes.end(), [&](NodeId node) {
    const int v = problem.variableOf(node);
    if (v < 0 || problem.tangentSize(v) == 0) return false;
    double state[32];
    if (problem.node(v)->stateSize() > 32 || graph.nodeSlots()[node.value] != problem.node(v))
      return false;
    problem.node(v)->readState(state);
    return std::equal(state, state + problem.node(v)->stateSize(), problem.estimate(v));
  });
}

}  // namespace dynemo::backend
