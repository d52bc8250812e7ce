#include <cstdio>
#include <istream>
#include <ostream>

#include "dynemo/core/mrpt_conversions.h"

#include "dynemo/backend/g2o_io.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "g2o_edge.h"
#include "g2o_information.h"
#include "g2o_line.h"

namespace dynemo {
namespace {

std::string numberText(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), " %.17g", value);
  return buffer;
}

std::string poseText(const Pose3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  std::string text;
  for (const double v : {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()})
    text += numberText(v);
  return text;
}

std::string anglesText(const Pose3& T) {
  double yaw = 0, pitch = 0, roll = 0;
  toMrpt(T).getYawPitchRoll(yaw, pitch, roll);
  std::string text;
  for (const double v : {T.t.x(), T.t.y(), T.t.z(), roll, pitch, yaw}) text += numberText(v);
  return text;
}

std::string informationText(const CEdgeRelativePose& edge) {
  const bool as_is = dynamic_cast<const backend::G2oEdge*>(&edge) != nullptr;
  const Matrix6 m = as_is ? Matrix6(edge.information()) : toG2oInformation(edge.information());
  std::string text;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) text += numberText(m(r, c));
  return text;
}

}  // namespace

void writeG2o(std::ostream& out, const CSceneGraph& graph, const G2oWriteOptions& options) {
  const auto written = [&](NodeId id) {
    return graph.findNode<CNodeKeyframe>(id) ||
           (options.entities && graph.findNode<CNodeEntity>(id));
  };
  for (const auto& node : graph.nodeSlots()) {
    if (!node || !written(node->id)) continue;
    const auto& pose = static_cast<const CNodePose&>(*node);
    out << "VERTEX_SE3:QUAT " << node->id << poseText(pose.T_map_node) << '\n';
  }
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge || !written(edge->nodes.front()) || !written(edge->nodes.back())) continue;
    if (dynamic_cast<const CEdgePosePrior*>(edge.get())) {
      out << "FIX " << edge->nodes[0] << '\n';
    } else if (const auto* relative = dynamic_cast<const CEdgeRelativePose*>(edge.get())) {
      out << "EDGE_SE3:QUAT " << edge->nodes[0] << ' ' << edge->nodes[1]
          << poseText(relative->T_1_2) << informationText(*relative) << '\n';
    }
  }
}

void rewriteG2o(std::istream& in, const std::string& name, const G2oContents& contents,
                std::ostream& out) {
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    backend::Line line(text, name, number);
    const std::string tag(line.word());
    const bool angles = tag == "VERTEX3";
    if (!angles && tag != "VERTEX_SE3:QUAT") {
      out << text << '\n';
      continue;
    }
    const std::uint64_t id = line.id();
    const auto node = contents.node_of_vertex.find(id);
    if (node == contents.node_of_vertex.end()) {  // merged into another
      out << text << '\n';
      continue;
    }
    const Pose3& T = contents.graph.getNode<CNodePose>(node->second).T_map_node;
    out << tag << ' ' << id << (angles ? anglesText(T) : poseText(T)) << '\n';
  }
  if (in.bad()) throw DataError(name + ": cannot be read");
}

}  // namespace dynemo
