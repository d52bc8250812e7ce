#include "dynemo/core/output_file.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

class KeyframesExporter : public Exporter {
 public:
  std::string fileName() const override { return "keyframes.tum"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string text;
    for (const auto& keyframe : run.graph.keyframes()) {
      text += tumLine(keyframe->stamp, keyframe->T_map_base());
    }
    writeFileAtomically(file, text);
  }
};

}  // namespace

std::unique_ptr<Exporter> makeKeyframesExporter(const ExportParams&) {
  return std::make_unique<KeyframesExporter>();
}

}  // namespace dynemo
