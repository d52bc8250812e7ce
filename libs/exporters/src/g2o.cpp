// g2o text: VERTEX_SE3:QUAT and EDGE_SE3:QUAT (R. Kümmerle et al., "g2o: A General Framework for
// Graph Optimization", ICRA 2011, and the format page of its repository). Vertex ids are the scene
// graph's node ids.
//
// g2o's edge error is (t, q_v), the translation and the quaternion's vector part of measurement⁻¹ ·
// (T_i⁻¹ T_j). Near zero q_v = r/2 of our tangent r, so that information entries grow by 2 per
// rotation index. Robust kernels are not part of the format.
#include <map>

#include "dynemo/core/output_file.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

std::string vertexComment(const CNodePose& node) {
  std::string text = "# " + std::to_string(node.id.value) + " " + node.kind();
  if (const auto* keyframe = dynamic_cast<const CNodeKeyframe*>(&node)) {
    text += " stamp " + keyframe->stamp.text();
  } else if (const auto* entity = dynamic_cast<const CNodeEntity*>(&node)) {
    text += " " + std::to_string(entity->entity.value) + " stamp " + entity->stamp.text();
  }
  return text + '\n';
}

std::string vertexLine(const CNodePose& node) {
  return "VERTEX_SE3:QUAT " + std::to_string(node.id.value) + " " + exactPoseText(node.T_map_node) +
         '\n';
}

std::string edgeLine(const CEdgeRelativePose& edge) {
  std::string text = "EDGE_SE3:QUAT " + std::to_string(edge.nodes[0].value) + " " +
                     std::to_string(edge.nodes[1].value) + " " + exactPoseText(edge.T_1_2);
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) {
      const double scale = (r < 3 ? 1.0 : 2.0) * (c < 3 ? 1.0 : 2.0);
      text += ' ' + exactText(scale * edge.information()(r, c));
    }
  return text + '\n';
}

/// The edges that SE(3) vertices and relative poses cannot express, by kind.
std::string leftOutComment(const std::map<std::string, int>& counts) {
  std::string text;
  for (const auto& [kind, count] : counts) {
    text += "# left out: " + std::to_string(count) + " " + kind + " edges\n";
  }
  return text;
}

class G2oExporter : public Exporter {
 public:
  std::string fileName() const override { return "graph.g2o"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string comments = "# vertex id = node id of the scene graph\n", vertices, edges;
    for (const auto& slot : run.graph.nodeSlots()) {
      const auto* node = dynamic_cast<const CNodePose*>(slot.get());
      if (!node) continue;
      comments += vertexComment(*node);
      vertices += vertexLine(*node);
    }
    std::map<std::string, int> left_out;
    for (const auto& slot : run.graph.edgeSlots()) {
      if (const auto* edge = dynamic_cast<const CEdgeRelativePose*>(slot.get())) {
        edges += edgeLine(*edge);
      } else if (slot) {
        ++left_out[slot->kind()];
      }
    }
    const auto& keyframes = run.graph.keyframes();
    const std::string fix =
        keyframes.empty() ? "" : "FIX " + std::to_string(keyframes.front()->id.value) + '\n';
    writeFileAtomically(file, comments + leftOutComment(left_out) + vertices + fix + edges);
  }
};

}  // namespace

std::unique_ptr<Exporter> makeG2oExporter(const ExportParams&) {
  return std::make_unique<G2oExporter>();
}

}  // namespace dynemo
