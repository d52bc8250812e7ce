// MRPT's text format of mrpt::graphs::CNetworkOfPoses3DInf, written by MRPT itself at full
// precision. Node ids are the scene graph's. MRPT drops parallel edges when it reads a file: they
// are fused before. The file holds the whole information matrices, but the text reader of MRPT 2.5
// forgets the correlations among the three angles.
#include <mrpt/graphs/CNetworkOfPoses.h>

#include <limits>
#include <locale>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"
#include "dynemo/core/output_file.h"
#include "factories.h"
#include "keyframe_pose_graph.h"

namespace dynemo {
namespace {

/// MRPT's information belongs to (x, y, z, yaw, pitch, roll).
mrpt::poses::CPose3DPDFGaussianInf mrptEdge(const RelativePose& edge) {
  const auto tangent_cov = invertSpd(edge.information);
  if (!tangent_cov) throw DataError("graph.graph: an edge's information is not positive definite");
  mrpt::poses::CPose3DPDFGaussianInf out(toMrpt(edge.T_1_2));
  out.cov_inv = covarianceToMrpt(edge.T_1_2, Matrix6(*tangent_cov)).inverse_LLt();
  return out;
}

mrpt::graphs::CNetworkOfPoses3DInf toNetwork(const CSceneGraph& graph) {
  mrpt::graphs::CNetworkOfPoses3DInf network;
  for (const auto& keyframe : graph.keyframes()) {
    network.nodes[keyframe->id.value] = toMrpt(keyframe->T_map_base());
  }
  if (!graph.keyframes().empty()) network.root = graph.keyframes().front()->id.value;
  for (const auto& [pair, edge] : keyframePoseGraph(graph)) {
    network.insertEdge(pair.first.value, pair.second.value, mrptEdge(edge));
  }
  return network;
}

class MrptGraphExporter : public Exporter {
 public:
  std::string fileName() const override { return "graph.graph"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(std::numeric_limits<double>::max_digits10);
    toNetwork(run.graph).writeAsText(text);
    writeFileAtomically(file, text.str());
  }
};

}  // namespace

std::unique_ptr<Exporter> makeMrptGraphExporter(const ExportParams&) {
  return std::make_unique<MrptGraphExporter>();
}

}  // namespace dynemo
