// TUM trajectories for evo and others: of the robot (every frame) and of each entity (every
// observation), all in the map frame.
#include <cctype>

#include "dynemo/core/output_file.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

/// "entity_3_box_3.tum": the id, so that names never clash, and the name in letters that every file
/// system takes.
std::string entityFileName(const CNodeEntity& node) {
  std::string name = "entity_" + std::to_string(node.entity.value);
  if (!node.name.empty()) name += '_';
  for (const char c : node.name) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name + ".tum";
}

class TumExporter : public Exporter {
 public:
  std::string fileName() const override { return "poses"; }
  void write(const RunResult& run, const std::filesystem::path& folder) const override {
    std::map<std::string, std::string> files;
    std::string& robot = files["robot.tum"];
    for (const FramePose& frame : run.frames) robot += tumLine(frame.stamp, frame.T_map_base);
    for (const auto& [id, track] : run.graph.tracks()) {
      std::string& text = files[entityFileName(*track.front())];
      for (const auto& node : track) text += tumLine(node->stamp, node->T_map_entity());
    }
    writeFolderAtomically(folder, files);
  }
};

}  // namespace

std::unique_ptr<Exporter> makeTumExporter(const ExportParams&) {
  return std::make_unique<TumExporter>();
}

}  // namespace dynemo
