// The scene graph in layers as glTF: map points, floors, edges by kind, keyframes, the robot's way,
// entities with their tracks. One animation plays the run: the robot and the entities move.
#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/query/scene_query.h"
#include "edge_lines.h"
#include "entity_color.h"
#include "factories.h"
#include "gltf_builder.h"
#include "map_cloud.h"
#include "picture_points.h"
#include "plane_faces.h"

namespace dynemo {
namespace {

using Json = GltfBuilder::Json;

constexpr std::uint32_t kPathRgb = 0x1a4fd6, kFloorRgb = 0xb8b8b8, kRobotRgb = 0x1a4fd6;

std::vector<Eigen::Vector3f> boxTriangles(const Vector3& min, const Vector3& max) {
  const auto corner = [&](int i) {
    return Eigen::Vector3f(
        Vector3(i & 1 ? max.x() : min.x(), i & 2 ? max.y() : min.y(), i & 4 ? max.z() : min.z())
            .cast<float>());
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::vector<Eigen::Vector3f> triangles;
  for (const auto& face : kFaces) {
    for (const int i : {0, 1, 2, 0, 2, 3}) triangles.push_back(corner(face[i]));
  }
  return triangles;
}

class Writer {
 public:
  Writer(const RunResult& run, const ExportParams& params)
      : run_(run), params_(params), begin_(firstStamp(run)) {}

  GltfBuilder build() {
    addPoints();
    addFloors();
    addPlanes();
    addEdges();
    addKeyframes();
    addRobot();
    addEntities();
    return std::move(gltf_);
  }

 private:
  int layer(const std::string& name) { return gltf_.addNode({name, {}, {}, {}, {}}); }

  void addPointsNode(int parent, const std::string& name, const std::vector<PicturePoint>& points) {
    if (points.empty()) return;
    GltfMesh mesh{name, GltfMode::kPoints, {}, {}, {}};
    for (const PicturePoint& p : points) {
      mesh.positions.push_back(p.p_map);
      mesh.colors.push_back(p.rgb);
    }
    gltf_.addNode({name, parent, gltf_.addMesh(mesh), {}, {}});
  }

  void addPoints() {
    const PicturePoints points = picturePoints(run_, params_);
    const int parent = layer("map points");
    addPointsNode(parent, "structure", points.structure);
    addPointsNode(parent, "entity fragments", points.fragments);
  }

  void addFloors() {
    const int parent = layer("floors");
    constexpr double kThickness_m = 0.01, kOpacity = 0.35;
    for (const auto& floor : run_.graph.floors()) {
      const auto area = floorArea(run_.graph, *floor);
      if (!area) continue;
      const Vector3 min(area->min().x(), area->min().y(), -kThickness_m);
      const Vector3 max(area->max().x(), area->max().y(), 0.0);
      const std::string name = "floor " + std::to_string(floor->id.value);
      const int mesh = gltf_.addMesh(
          {name, GltfMode::kTriangles, boxTriangles(min, max), {}, {kFloorRgb, kOpacity}});
      gltf_.addNode({name,
                     parent,
                     mesh,
                     Pose3::translation(0.0, 0.0, floor->level_m),
                     {{"node", floor->id.value}, {"level_m", floor->level_m}}});
    }
  }

  void addPlanes() {
    const int parent = layer("planes");
    for (const PlaneFace& face : planeFaces(run_.graph)) {
      if (face.triangles.empty()) continue;
      GltfMesh mesh{face.title(), GltfMode::kTriangles, {}, {}, {kPlaneRgb, 0.4}};
      for (const Vector3& p : face.triangles) mesh.positions.push_back(p.cast<float>());
      const Plane3& plane = face.plane->plane_map;
      gltf_.addNode({face.title(),
                     parent,
                     gltf_.addMesh(mesh),
                     {},
                     {{"node", face.plane->id.value},
                      {"normal", {plane.normal.x(), plane.normal.y(), plane.normal.z()}},
                      {"d", plane.d_m},
                      {"area_m2", face.area_m2}}});
    }
  }

  void addEdges() {
    const int parent = layer("edges");
    for (const EdgeKindLines& kind : edgeLines(run_.graph)) {
      GltfMesh mesh{kind.kind, GltfMode::kLines, {}, {}, {kind.color_rgb, 1.0}};
      for (const EdgeLines& edge : kind.edges) {
        for (const EdgeLine& line : edge.lines) {
          mesh.positions.push_back(line.from.cast<float>());
          mesh.positions.push_back(line.to.cast<float>());
        }
      }
      gltf_.addNode({kind.kind, parent, gltf_.addMesh(mesh), {}, {{"edges", kind.edges.size()}}});
    }
  }

  void addKeyframes() {
    const int parent = layer("keyframes");
    if (run_.graph.keyframes().empty()) return;
    constexpr float kAxis_m = 0.15f;
    GltfMesh axes{"keyframe", GltfMode::kLines, {}, {}, {}};
    for (int axis = 0; axis < 3; ++axis) {
      axes.positions.push_back(Eigen::Vector3f::Zero());
      axes.positions.push_back(kAxis_m * Eigen::Vector3f::Unit(axis));
      const std::uint32_t rgb = axis == 0 ? 0xd62728 : axis == 1 ? 0x2ca02c : 0x1f77b4;
      axes.colors.insert(axes.colors.end(), 2, rgb);
    }
    const int mesh = gltf_.addMesh(axes);
    for (const auto& keyframe : run_.graph.keyframes()) {
      gltf_.addNode({"keyframe " + std::to_string(keyframe->id.value),
                     parent,
                     mesh,
                     keyframe->T_map_base(),
                     {{"node", keyframe->id.value},
                      {"stamp", keyframe->stamp.text()},
                      {"reasons", keyframeReasonText(keyframe->reasons)}}});
    }
  }

  void addRobot() {
    const int parent = layer("robot");
    if (run_.frames.empty()) return;
    std::vector<double> times_s;
    std::vector<Pose3> poses;
    GltfMesh way{"trajectory", GltfMode::kLineStrip, {}, {}, {kPathRgb, 1.0}};
    for (const FramePose& frame : run_.frames) {
      addKey(times_s, poses, frame.stamp, frame.T_map_base);
      way.positions.push_back(frame.T_map_base.t.cast<float>());
    }
    if (way.positions.size() > 1) gltf_.addNode({"trajectory", parent, gltf_.addMesh(way), {}, {}});
    const int mesh = gltf_.addMesh({"robot",
                                    GltfMode::kTriangles,
                                    boxTriangles({-0.25, -0.2, 0.0}, {0.25, 0.2, 0.3}),
                                    {},
                                    {kRobotRgb, 0.6}});
    const int node = gltf_.addNode({"base", parent, mesh, poses.front(), {}});
    if (times_s.size() > 1) gltf_.animate(node, times_s, poses, false);
  }

  /// Times must ascend strictly, as floats too.
  void addKey(std::vector<double>& times_s, std::vector<Pose3>& poses, Stamp stamp,
              const Pose3& T) const {
    const double time_s = secondsBetween(begin_, stamp);
    if (!times_s.empty() && static_cast<float>(time_s) <= static_cast<float>(times_s.back()))
      return;
    if (time_s < 0.0) return;
    times_s.push_back(time_s);
    poses.push_back(T);
  }

  void addEntities() {
    const int parent = layer("entities");
    for (const auto& [id, track] : run_.graph.tracks()) addEntity(parent, track);
  }

  void addEntity(int parent, const EntityTrack& track) {
    const CNodeEntity& last = *track.back();
    const std::uint32_t rgb = entityRgb(last.entity);
    const bool agent = last.semantic_class == SemanticClass::kAgent;
    const Extent extent = extentOf(fragmentPoints(run_.graph, track)).value_or(Extent());
    const std::string title = entityTitle(last);
    const int group = gltf_.addNode({title,
                                     parent,
                                     {},
                                     {},
                                     {{"entity", last.entity.value},
                                      {"class", semanticClassName(last.semantic_class)},
                                      {"observations", track.size()},
                                      {"last_seen", last.stamp.text()}}});
    const int mesh = gltf_.addMesh(
        {title, GltfMode::kTriangles, boxTriangles(extent.min, extent.max), {}, {rgb, 0.5}});
    const int box = gltf_.addNode({title + " box", group, mesh, last.T_map_entity(), {}});

    std::vector<double> times_s;
    std::vector<Pose3> poses;
    GltfMesh way{title + " track", GltfMode::kLineStrip, {}, {}, {rgb, 1.0}};
    for (const auto& node : track) {
      addKey(times_s, poses, node->stamp, node->T_map_entity());
      way.positions.push_back(node->T_map_entity().t.cast<float>());
    }
    if (agent && way.positions.size() > 1)
      gltf_.addNode({"track", group, gltf_.addMesh(way), {}, {}});
    if (times_s.size() > 1) gltf_.animate(box, times_s, poses, !agent);
    if (!agent) addMoves(group, track, extent, rgb);
  }

  /// The box where it was and a line to where it went.
  void addMoves(int group, const EntityTrack& track, const Extent& extent, std::uint32_t rgb) {
    const auto stays = staysOf(track, run_.entity_covariances, params_.query);
    for (std::size_t i = 1; i < stays.size(); ++i) {
      const Pose3 &from = stays[i - 1].T_map_entity, &to = stays[i].T_map_entity;
      const int ghost = gltf_.addMesh(
          {"before", GltfMode::kTriangles, boxTriangles(extent.min, extent.max), {}, {rgb, 0.15}});
      gltf_.addNode({"before move " + std::to_string(i), group, ghost, from, {}});
      const int line = gltf_.addMesh(
          {"move", GltfMode::kLines, {from.t.cast<float>(), to.t.cast<float>()}, {}, {rgb, 1.0}});
      gltf_.addNode({"move " + std::to_string(i),
                     group,
                     line,
                     {},
                     {{"last_before", stays[i - 1].last_seen.text()},
                      {"first_after", stays[i].first_seen.text()}}});
    }
  }

  const RunResult& run_;
  const ExportParams& params_;
  Stamp begin_;
  GltfBuilder gltf_;
};

class GltfExporter : public Exporter {
 public:
  explicit GltfExporter(const ExportParams& params) : params_(params) {}
  std::string fileName() const override { return "scene.glb"; }
  std::vector<std::string> extensions() const override { return {".glb", ".gltf"}; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    const GltfBuilder gltf = Writer(run, params_).build();
    writeFileAtomically(file, file.extension() == ".gltf" ? gltf.gltf() : gltf.glb());
  }

 private:
  ExportParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makeGltfExporter(const ExportParams& params) {
  return std::make_unique<GltfExporter>(params);
}

}  // namespace dynemo
