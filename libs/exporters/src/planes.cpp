// One row per plane node, by node id. The covariance is that of the plane's tangent [w_1 w_2 d]
// (core/plane3.h): rotation of the normal about the axes of its tangent basis, and offset; rad²,
// rad·m, m². It is empty where the run computed none.
#include "dynemo/core/output_file.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/seen_plane.h"
#include "factories.h"
#include "pose_text.h"

namespace dynemo {
namespace {

constexpr const char* kHeader =
    "node_id,floor_id,n_x,n_y,n_z,d,observations,points,area_m2,center_x,center_y,center_z,"
    "var_w1,var_w2,var_d,cov_w1_w2,cov_w1_d,cov_w2_d\n";

std::string covarianceColumns(const Matrix3* covariance) {
  constexpr int kEntries[][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  std::string text;
  for (const auto& [r, c] : kEntries)
    text += ',' + (covariance ? exactNumber((*covariance)(r, c)) : "");
  return text;
}

std::string row(const RunResult& run, const CNodePlane& plane) {
  std::size_t observations = 0, points = 0;
  for (const EdgeId id : run.graph.edgesOf(plane.id)) {
    const auto* edge =
        dynamic_cast<const CEdgeKeyframePlane*>(run.graph.edgeSlots()[id.value].get());
    if (!edge) continue;
    ++observations;
    points += edge->point_count;
  }
  const PlanePatch patch = seenPatch(run.graph, plane);
  std::string text = std::to_string(plane.id.value) + ',';
  if (const auto floor = floorOf(run.graph, plane)) text += std::to_string(floor->value);
  const Vector3& n = plane.plane_map.normal;
  for (const double v : {n.x(), n.y(), n.z(), plane.plane_map.d_m}) text += ',' + fixedText(v);
  text += ',' + std::to_string(observations) + ',' + std::to_string(points) + ',' +
          fixedText(patch.area_m2());
  const Vector3 center = middleOf(patch);
  for (const double v : {center.x(), center.y(), center.z()}) text += ',' + fixedText(v);
  const Matrix3* covariance = nullptr;
  if (run.plane_covariances) {
    const auto it = run.plane_covariances->find(plane.id);
    if (it != run.plane_covariances->end()) covariance = &it->second;
  }
  return text + covarianceColumns(covariance) + '\n';
}

class PlanesExporter : public Exporter {
 public:
  std::string fileName() const override { return "planes.csv"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    std::string text = kHeader;
    for (const auto& plane : run.graph.planes()) text += row(run, *plane);
    writeFileAtomically(file, text);
  }
};

}  // namespace

std::unique_ptr<Exporter> makePlanesExporter(const ExportParams&) {
  return std::make_unique<PlanesExporter>();
}

}  // namespace dynemo
