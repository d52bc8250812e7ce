// PCL's PCD 0.7, binary: position [m, map frame], colour, class (as `label`) and entity of each
// point. PCL reads `rgb` as a float that holds the bytes 0x00RRGGBB.
#include "binary_text.h"
#include "dynemo/core/output_file.h"
#include "factories.h"
#include "map_cloud.h"

namespace dynemo {
namespace {

std::string header(std::size_t points, Stamp at) {
  const std::string count = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\n"
         "# map frame, metres; entities as of " +
         at.text() +
         "\n# label: 0 structure, 1 object, 2 agent\n"
         "VERSION 0.7\nFIELDS x y z rgb label entity\nSIZE 4 4 4 4 4 4\nTYPE F F F F U I\n"
         "COUNT 1 1 1 1 1 1\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
}

void appendPoint(std::string& bytes, const MapPoint& point) {
  for (int axis = 0; axis < 3; ++axis) append(bytes, point.p_map[axis]);
  append(bytes, pointClassColor(point.semantic_class));
  append(bytes, static_cast<std::uint32_t>(point.semantic_class));
  append(bytes, point.entity);
}

class PcdExporter : public Exporter {
 public:
  explicit PcdExporter(const ExportParams& params) : params_(params) {}
  std::string fileName() const override { return "map.pcd"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    const auto points = mapCloud(run, params_);
    std::string bytes = header(points.size(), cloudStamp(run, params_.cloud));
    for (const MapPoint& point : points) appendPoint(bytes, point);
    writeFileAtomically(file, bytes);
  }

 private:
  ExportParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makePcdExporter(const ExportParams& params) {
  return std::make_unique<PcdExporter>(params);
}

}  // namespace dynemo
