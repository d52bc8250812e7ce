#include "dynemo/core/output_file.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

class OdometryExporter : public Exporter {
 public:
  std::string fileName() const override { return "odometry.tum"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string text;
    for (const FramePose& frame : run.frames) text += tumLine(frame.stamp, frame.T_odom_base);
    writeFileAtomically(file, text);
  }
};

}  // namespace

std::unique_ptr<Exporter> makeOdometryExporter(const ExportParams&) {
  return std::make_unique<OdometryExporter>();
}

}  // namespace dynemo
