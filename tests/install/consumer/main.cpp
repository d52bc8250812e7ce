// What another project writes to use the graph and the back-end: a measured step of 1 m, first
// believed to be 3 m.
#include <cstdio>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

int main() {
  using namespace dynemo;
  const auto start = std::make_shared<CNodeKeyframe>(), end = std::make_shared<CNodeKeyframe>();
  end->id = NodeId{1};
  end->T_map_node = Pose3::translation(3.0, 0.0, 0.0);
  const auto anchor = std::make_shared<CEdgePosePrior>();
  anchor->nodes = {NodeId{0}};
  anchor->setInformation(Matrix6::Identity());
  const auto step = std::make_shared<CEdgeOdometry>();
  step->id = EdgeId{1};
  step->nodes = {NodeId{0}, NodeId{1}};
  step->T_1_2 = Pose3::translation(1.0, 0.0, 0.0);
  step->setInformation(Matrix6::Identity());

  CSceneGraph graph;
  graph.apply({.nodes = {start, end}, .edges = {anchor, step}});
  const OptimizationReport report = Optimizer(SolverParams{}).optimize(graph);
  std::printf("cost %.3f -> %.3f, end at %.3f m\n", report.cost_before, report.cost_after,
              end->T_map_node.t.x());
  return report.usable() ? 0 : 1;
}
