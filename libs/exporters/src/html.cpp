// One self-contained web page that shows the run in three.js: the scene graph in layers over time.
// Everything numeric is base64 of little-endian arrays; points are quantised to 16 bits per axis.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base64.h"
#include "binary_text.h"
#include "dynemo/core/output_file.h"
#include "dynemo/query/scene_query.h"
#include "edge_lines.h"
#include "entity_color.h"
#include "factories.h"
#include "map_cloud.h"
#include "picture_points.h"
#include "plane_faces.h"
#include "scene_view.h"
#include "voxel_thinning.h"
#include "web_assets.h"

namespace dynemo {

using Json = nlohmann::ordered_json;

namespace {

/// How many steps a node is lifted when the layers are pulled apart; as in viewer.js.
std::uint8_t levelOf(const CNodeBase& node) {
  const std::string kind = node.kind();
  return kind == "keyframe" ? 1 : kind == "floor" ? 3 : 2;
}

class Floats {
 public:
  void add(double value) { append(bytes_, static_cast<float>(value)); }
  void add(const Vector3& v) {
    for (int axis = 0; axis < 3; ++axis) add(v[axis]);
  }
  void add(const Pose3& T) {
    add(T.t);
    const auto q = T.quaternion();
    for (const double value : {q.x(), q.y(), q.z(), q.w()}) add(value);
  }
  std::string text() const { return base64(bytes_); }

 private:
  std::string bytes_;
};

Json poseJson(const Pose3& T) {
  const auto q = T.quaternion();
  return {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()};
}

/// Positions in 65536 steps per axis, and colours when asked for.
Json pointsJson(const std::vector<PicturePoint>& points, bool with_colors) {
  Eigen::Vector3f min = Eigen::Vector3f::Zero(), max = Eigen::Vector3f::Zero();
  if (!points.empty()) min = max = points.front().p_map;
  for (const PicturePoint& p : points) {
    min = min.cwiseMin(p.p_map);
    max = max.cwiseMax(p.p_map);
  }
  const Eigen::Vector3f step = ((max - min) / 65535.0f).cwiseMax(1e-9f);
  std::string positions, colors;
  for (const PicturePoint& p : points) {
    for (int axis = 0; axis < 3; ++axis) {
      const float steps = std::round((p.p_map[axis] - min[axis]) / step[axis]);
      append(positions, static_cast<std::uint16_t>(std::min(steps, 65535.0f)));
    }
    for (const unsigned shift : {16u, 8u, 0u}) append(colors, static_cast<char>(p.rgb >> shift));
  }
  Json json = {{"count", points.size()},
               {"min", {min.x(), min.y(), min.z()}},
               {"step", {step.x(), step.y(), step.z()}},
               {"positions", base64(positions)}};
  if (with_colors) json["colors"] = base64(colors);
  return json;
}

class Writer {
 public:
  Writer(const RunResult& run, const ExportParams& params)
      : run_(run), params_(params), begin_(firstStamp(run)) {}

  Json json() const {
    const SceneView view = viewOf(run_.graph);
    return {{"begin", begin_.text()},
            {"duration", duration_s()},
            {"view",
             {{"center", {view.center.x(), view.center.y(), view.center.z()}},
              {"radius", view.radius_m},
              {"yaw", view.yaw_rad}}},
            {"points", pointsJson(picturePoints(run_, params_).structure, true)},
            {"frames", framesText()},
            {"odometry", odometryText()},
            {"keyframes", keyframesJson()},
            {"floors", floorsJson()},
            {"planes", planesJson()},
            {"entities", entitiesJson()},
            {"edge_count", run_.graph.edgeCount()},
            {"edges", edgesJson()}};
  }

 private:
  double after(Stamp stamp) const { return secondsBetween(begin_, stamp); }

  double duration_s() const {
    Stamp end = lastStamp(run_);
    for (const auto& [id, track] : run_.graph.tracks()) end = std::max(end, track.back()->stamp);
    return std::max(0.0, after(end));
  }

  std::string framesText() const {
    Floats floats;
    for (const FramePose& frame : run_.frames) {
      floats.add(after(frame.stamp));
      floats.add(frame.T_map_base);
    }
    return floats.text();
  }

  std::string odometryText() const {
    Floats floats;
    for (const Vector3& p : uncorrectedWay(run_)) floats.add(p);
    return floats.text();
  }

  Json keyframesJson() const {
    Json list = Json::array();
    for (const auto& keyframe : run_.graph.keyframes()) {
      list.push_back({{"id", keyframe->id.value},
                      {"t", after(keyframe->stamp)},
                      {"pose", poseJson(keyframe->T_map_base())},
                      {"reasons", keyframeReasonText(keyframe->reasons)}});
    }
    return list;
  }

  Json floorsJson() const {
    Json list = Json::array();
    for (const auto& floor : run_.graph.floors()) {
      const auto area = floorArea(run_.graph, *floor);
      if (!area) continue;
      list.push_back(
          {{"id", floor->id.value},
           {"level", floor->level_m},
           {"area", {area->min().x(), area->min().y(), area->max().x(), area->max().y()}}});
    }
    return list;
  }

  Json planesJson() const {
    Json list = Json::array();
    for (const PlaneFace& face : planeFaces(run_.graph)) {
      Floats triangles;
      for (const Vector3& p : face.triangles) triangles.add(p);
      char area[32];
      std::snprintf(area, sizeof(area), "%.1f m\u00b2", face.area_m2);
      list.push_back({{"title", face.title() + (face.is_ceiling ? " (ceiling)\n" : "\n") + area},
                      {"ceiling", face.is_ceiling},
                      {"color", kPlaneRgb},
                      {"triangles", triangles.text()}});
    }
    return list;
  }

  Json entitiesJson() const {
    const SceneQuery query(run_.graph, run_.entity_covariances, params_.query);
    Json list = Json::array();
    for (const auto& [id, track] : run_.graph.tracks()) list.push_back(entityJson(query, track));
    return list;
  }

  Json entityJson(const SceneQuery& query, const EntityTrack& track) const {
    const CNodeEntity& last = *track.back();
    const std::vector<Vector3> points = fragmentPoints(run_.graph, track);
    const Extent extent = extentOf(points).value_or(Extent());
    Floats rows;
    for (const Sighting& s : query.track(last.entity)) {
      rows.add(after(s.stamp));
      rows.add(s.T_map_entity);
      const bool known = s.covariance.has_value();
      rows.add(known ? std::sqrt(s.covariance->topLeftCorner<3, 3>().trace()) : -1.0);
      rows.add(s.moved ? 1.0 : 0.0);
    }
    return {{"id", last.entity.value},
            {"title", entityTitle(last)},
            {"class", semanticClassName(last.semantic_class)},
            {"color", entityRgb(last.entity)},
            {"min", {extent.min.x(), extent.min.y(), extent.min.z()}},
            {"max", {extent.max.x(), extent.max.y(), extent.max.z()}},
            {"points", pointsJson(entityPoints(points, extent), false)},
            {"moves", movesJson(query, track)},
            {"track", rows.text()}};
  }

  /// Those in its box, thinned: of agents, each observation adds another pose of the limbs.
  std::vector<PicturePoint> entityPoints(const std::vector<Vector3>& points,
                                         const Extent& extent) const {
    constexpr double kSlack_m = 0.05;
    constexpr std::size_t kMost = 4000;
    const Eigen::AlignedBox3d box(extent.min - Vector3::Constant(kSlack_m),
                                  extent.max + Vector3::Constant(kSlack_m));
    std::vector<PicturePoint> inside;
    for (const Vector3& p : points) {
      if (box.contains(p)) inside.push_back({p.cast<float>(), 0});
    }
    return withinBudget(std::move(inside), 0.5 * params_.picture.voxel_m, kMost);
  }

  Json movesJson(const SceneQuery& query, const EntityTrack& track) const {
    Json list = Json::array();
    if (track.front()->semantic_class == SemanticClass::kAgent) return list;
    for (const Move& m : query.movesOf(track.front()->entity)) {
      list.push_back({{"from", poseJson(m.T_map_before)},
                      {"to", poseJson(m.T_map_after)},
                      {"distance", m.distance()},
                      {"before", after(m.last_before)},
                      {"after", after(m.first_after)}});
    }
    return list;
  }

  /// When the last of an edge's nodes came.
  double edgeTime(const EdgeLines& edge) const {
    double time_s = 0.0;
    for (const NodeId node : edge.nodes) {
      if (const auto* keyframe = run_.graph.findNode<CNodeKeyframe>(node))
        time_s = std::max(time_s, after(keyframe->stamp));
      if (const auto* entity = run_.graph.findNode<CNodeEntity>(node))
        time_s = std::max(time_s, after(entity->stamp));
    }
    return time_s;
  }

  Json edgesJson() const {
    Json list = Json::array();
    for (EdgeKindLines& kind : edgeLines(run_.graph)) {
      std::stable_sort(
          kind.edges.begin(), kind.edges.end(),
          [this](const EdgeLines& a, const EdgeLines& b) { return edgeTime(a) < edgeTime(b); });
      Floats segments, info;
      std::string levels;
      for (const EdgeLines& edge : kind.edges) addEdge(edge, segments, info, levels);
      list.push_back({{"kind", kind.kind},
                      {"color", kind.color_rgb},
                      {"count", kind.edges.size()},
                      {"segments", segments.text()},
                      {"levels", base64(levels)},
                      {"info", info.text()}});
    }
    return list;
  }

  void addEdge(const EdgeLines& edge, Floats& segments, Floats& info, std::string& levels) const {
    for (const EdgeLine& line : edge.lines) {
      segments.add(line.from);
      segments.add(line.to);
      append(levels, levelOf(run_.graph.getNode<CNodeBase>(line.node_from)));
      append(levels, levelOf(run_.graph.getNode<CNodeBase>(line.node_to)));
      info.add(edgeTime(edge));
      info.add(static_cast<double>(edge.id.value));
      info.add(edge.squared_error);
      info.add(edge.residual_size);
    }
  }

  const RunResult& run_;
  const ExportParams& params_;
  Stamp begin_;
};

/// JSON that may stand inside a script element.
std::string scriptSafe(const Json& json) {
  std::string safe;
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

/// The page with each @NAME@ replaced; what is put in is not searched again.
std::string filledPage(const std::string& data) {
  const std::pair<std::string_view, std::string_view> parts[] = {
      {"@VIEWER_CSS@", viewerStyle()},     {"@DATA@", data},
      {"@THREE_LICENSE@", threeLicense()}, {"@THREE@", threeScript()},
      {"@CONTROLS@", controlsScript()},    {"@VIEWER_JS@", viewerScript()}};
  std::string_view rest = viewerPage();
  std::string page;
  for (const auto& [name, content] : parts) {
    const std::size_t at = rest.find(name);
    if (at == std::string_view::npos)
      throw std::logic_error("viewer.html has no " + std::string(name));
    page += rest.substr(0, at);
    page += content;
    rest.remove_prefix(at + name.size());
  }
  return page.append(rest);
}

class HtmlExporter : public Exporter {
 public:
  explicit HtmlExporter(const ExportParams& params) : params_(params) {}
  std::string fileName() const override { return "scene.html"; }
  std::vector<std::string> extensions() const override { return {".html", ".htm"}; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    writeFileAtomically(file, filledPage(scriptSafe(Writer(run, params_).json())));
  }

 private:
  ExportParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makeHtmlExporter(const ExportParams& params) {
  return std::make_unique<HtmlExporter>(params);
}

}  // namespace dynemo
