// Stanford PLY, binary: position [m, map frame], colour, class and entity of each point.
#include "binary_text.h"
#include "dynemo/core/output_file.h"
#include "factories.h"
#include "map_cloud.h"

namespace dynemo {
namespace {

std::string header(const std::vector<MapPoint>& points, Stamp at) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\ncomment map frame, metres\n"
      "comment entities as of " +
      at.text() + "\n";
  for (const PointClass c : {PointClass::kStructure, PointClass::kObject, PointClass::kAgent}) {
    text += "comment class " + std::to_string(static_cast<int>(c)) + ' ' + pointClassName(c) + '\n';
  }
  text += "element vertex " + std::to_string(points.size()) + '\n';
  for (const char* property : {"float x", "float y", "float z", "uchar red", "uchar green",
                               "uchar blue", "uchar class", "int entity"}) {
    text += std::string("property ") + property + '\n';
  }
  return text + "end_header\n";
}

void appendPoint(std::string& bytes, const MapPoint& point) {
  for (int axis = 0; axis < 3; ++axis) append(bytes, point.p_map[axis]);
  const std::uint32_t rgb = pointClassColor(point.semantic_class);
  for (const unsigned shift : {16u, 8u, 0u}) append(bytes, static_cast<std::uint8_t>(rgb >> shift));
  append(bytes, static_cast<std::uint8_t>(point.semantic_class));
  append(bytes, point.entity);
}

class PlyExporter : public Exporter {
 public:
  explicit PlyExporter(const ExportParams& params) : params_(params) {}
  std::string fileName() const override { return "map.ply"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    const auto points = mapCloud(run, params_);
    std::string bytes = header(points, cloudStamp(run, params_.cloud));
    for (const MapPoint& point : points) appendPoint(bytes, point);
    writeFileAtomically(file, bytes);
  }

 private:
  ExportParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makePlyExporter(const ExportParams& params) {
  return std::make_unique<PlyExporter>(params);
}

}  // namespace dynemo
