#include "mrpt_reference.h"

#include <mrpt/graphslam/levmarq.h>

#include "benchmark_support.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo::test {

MrptResult solveWithMrpt(const CSceneGraph& graph, double min_relative_step) {
  mrpt::graphs::CNetworkOfPoses3DInf network;
  std::size_t taken = 0;
  for (const auto& edge : graph.edgeSlots()) {
    const auto* relative = dynamic_cast<const CEdgeRelativePose*>(edge.get());
    if (!relative) continue;
    ++taken;
    mrpt::poses::CPose3DPDFGaussianInf measured(toMrpt(relative->T_1_2));
    measured.cov_inv =
        covarianceToMrpt(relative->T_1_2, Matrix6(*invertSpd(relative->information())))
            .inverse_LLt();
    network.insertEdge(edge->nodes[0].value, edge->nodes[1].value, measured);
    for (const NodeId node : edge->nodes)
      network.nodes[node.value] = toMrpt(graph.findNode<CNodePose>(node)->T_map_node);
  }
  network.root = network.nodes.begin()->first;
  mrpt::containers::yaml options;
  options["e2"] = min_relative_step;
  mrpt::graphslam::TResultInfoSpaLevMarq info;
  MrptResult result;
  result.seconds = secondsOf(
      [&] { mrpt::graphslam::optimize_graph_spa_levmarq(network, info, nullptr, options); });
  result.iterations = static_cast<int>(info.num_iters);
  result.edges_share = static_cast<double>(taken) / static_cast<double>(graph.edgeCount());
  return result;
}

}  // namespace dynemo::test
