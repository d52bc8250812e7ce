// Tables for spreadsheets and pandas: every node and every edge of any kind, and the moves of
// objects.
#include "csv_text.h"
#include "dynemo/core/output_file.h"
#include "dynemo/query/scene_query.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

/// The stamp of nodes that have one.
std::string stampOf(const CNodeBase& node) {
  if (const auto* keyframe = dynamic_cast<const CNodeKeyframe*>(&node))
    return keyframe->stamp.text();
  if (const auto* entity = dynamic_cast<const CNodeEntity*>(&node)) return entity->stamp.text();
  return "";
}

/// The state as a pose where it is one, else its numbers.
std::string stateOf(const CNodeBase& node) {
  if (const auto* pose = dynamic_cast<const CNodePose*>(&node))
    return poseText(pose->T_map_node, ' ');
  std::vector<double> state(static_cast<std::size_t>(node.stateSize()));
  node.readState(state.data());
  std::string text;
  for (const double value : state) text += (text.empty() ? "" : " ") + exactNumber(value);
  return text;
}

std::string nodesTable(const CSceneGraph& graph) {
  std::string text = "node_id,kind,timestamp,entity_id,name,edges,state\n";
  for (const auto& node : graph.nodeSlots()) {
    if (!node) continue;
    const auto* entity = dynamic_cast<const CNodeEntity*>(node.get());
    text += std::to_string(node->id.value) + ',' + node->kind() + ',' + stampOf(*node) + ',' +
            (entity ? std::to_string(entity->entity.value) : "") + ',' +
            (entity ? csvText(entity->name) : "") + ',' +
            std::to_string(graph.edgesOf(node->id).size()) + ',' + stateOf(*node) + '\n';
  }
  return text;
}

std::string edgesTable(const CSceneGraph& graph) {
  std::string text = "edge_id,kind,nodes,kernel,residual_size,mahalanobis2,cost\n";
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge) continue;
    std::string nodes;
    for (const NodeId node : edge->nodes)
      nodes += (nodes.empty() ? "" : " ") + std::to_string(node.value);
    text += std::to_string(edge->id.value) + ',' + edge->kind() + ',' + nodes + ',' +
            kernelName(edge->kernel.type) + ',' + std::to_string(edge->residualSize()) + ',' +
            exactNumber(graph.squaredError(*edge)) + ',' + exactNumber(graph.edgeCost(*edge)) +
            '\n';
  }
  return text;
}

std::string movesTable(const RunResult& run, const QueryParams& params) {
  std::string text = "entity_id,name,last_before,first_after,distance_m";
  for (const char* side : {"before", "after"}) {
    for (const char* column : {"x", "y", "z", "qx", "qy", "qz", "qw"})
      text += std::string(",") + side + '_' + column;
  }
  text += '\n';
  for (const Move& m : SceneQuery(run.graph, run.entity_covariances, params).moved()) {
    text += std::to_string(m.entity.value) + ',' + csvText(m.name) + ',' + m.last_before.text() +
            ',' + m.first_after.text() + ',' + exactNumber(m.distance()) + ',' +
            poseText(m.T_map_before, ',') + ',' + poseText(m.T_map_after, ',') + '\n';
  }
  return text;
}

class TablesExporter : public Exporter {
 public:
  explicit TablesExporter(const QueryParams& params) : params_(params) {}
  std::string fileName() const override { return "tables"; }
  void write(const RunResult& run, const std::filesystem::path& folder) const override {
    writeFolderAtomically(folder, {{"nodes.csv", nodesTable(run.graph)},
                                   {"edges.csv", edgesTable(run.graph)},
                                   {"moves.csv", movesTable(run, params_)}});
  }

 private:
  QueryParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makeTablesExporter(const ExportParams& params) {
  return std::make_unique<TablesExporter>(params.query);
}

}  // namespace dynemo
