// An exporter: where and when objects were found to have moved.
#include "moves_exporter.h"

#include "dynemo/core/output_file.h"

namespace dynemo {
namespace {

class MovesExporter : public Exporter {
 public:
  std::string fileName() const override { return "moves.csv"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string text = "entity_id,timestamp,x,y,z\n";
    for (const auto& [id, track] : run.graph.tracks())
      for (const auto& node : track) {
        if (!node->moved) continue;
        const Vector3 p_map = node->T_map_entity().t;
        text += std::to_string(id.value) + "," + node->stamp.text();
        for (const double v : {p_map.x(), p_map.y(), p_map.z()}) text += "," + exactNumber(v);
        text += "\n";
      }
    writeFileAtomically(file, text);  // completely or not at all
  }
};

}  // namespace

std::unique_ptr<Exporter> makeMovesExporter(const ExportParams&) {
  return std::make_unique<MovesExporter>();
}

}  // namespace dynemo
