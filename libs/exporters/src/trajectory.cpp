#include "dynemo/core/output_file.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

class TrajectoryExporter : public Exporter {
 public:
  std::string fileName() const override { return "trajectory.tum"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string text;
    for (const FramePose& frame : run.frames) text += tumLine(frame.stamp, frame.T_map_base);
    writeFileAtomically(file, text);
  }
};

}  // namespace

std::unique_ptr<Exporter> makeTrajectoryExporter(const ExportParams&) {
  return std::make_unique<TrajectoryExporter>();
}

}  // namespace dynemo
