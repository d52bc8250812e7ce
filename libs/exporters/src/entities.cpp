// The covariance columns are those of the estimated pose's right tangent [x y z rx ry rz]
// (core/se3.h): translation along the entity's own axes, rotation about them; m², m·rad, rad². They
// are empty where the run computed none.
#include "csv_text.h"
#include "dynemo/core/output_file.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};

std::string header() {
  std::string text = "node_id,entity_id,class,name,timestamp,keyframe_id,moved,x,y,z,qx,qy,qz,qw";
  for (const char* axis : kAxes) text += std::string(",var_") + axis;
  text += ",first_x,first_y,first_z,first_qx,first_qy,first_qz,first_qw";
  for (int r = 0; r < 6; ++r)
    for (int c = r + 1; c < 6; ++c) text += std::string(",cov_") + kAxes[r] + "_" + kAxes[c];
  return text + '\n';
}

std::string varianceColumns(const Matrix6* covariance) {
  std::string text;
  for (int i = 0; i < 6; ++i) text += ',' + (covariance ? exactNumber((*covariance)(i, i)) : "");
  return text;
}

std::string correlationColumns(const Matrix6* covariance) {
  std::string text;
  for (int r = 0; r < 6; ++r)
    for (int c = r + 1; c < 6; ++c) {
      text += ',' + (covariance ? exactNumber((*covariance)(r, c)) : "");
    }
  return text;
}

std::string row(const CNodeEntity& node, const Matrix6* covariance) {
  std::string text = std::to_string(node.id.value) + ',' + std::to_string(node.entity.value) + ',';
  text += semanticClassName(node.semantic_class);
  text += ',' + csvText(node.name) + ',' + node.stamp.text() + ',';
  text += std::to_string(node.keyframe.value) + ',' + (node.moved ? '1' : '0');
  text += ',' + poseText(node.T_map_entity(), ',') + varianceColumns(covariance);
  text += ',' + poseText(node.T_map_node_first, ',') + correlationColumns(covariance);
  return text + '\n';
}

class EntitiesExporter : public Exporter {
 public:
  std::string fileName() const override { return "entities.csv"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string text = header();
    for (const auto& slot : run.graph.nodeSlots()) {
      const auto* node = dynamic_cast<const CNodeEntity*>(slot.get());
      if (!node) continue;
      const auto it = run.entity_covariances.find(node->id);
      text += row(*node, it == run.entity_covariances.end() ? nullptr : &it->second);
    }
    writeFileAtomically(file, text);
  }
};

}  // namespace

std::unique_ptr<Exporter> makeEntitiesExporter(const ExportParams&) {
  return std::make_unique<EntitiesExporter>();
}

}  // namespace dynemo
