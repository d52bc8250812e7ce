// Scene graphs for spark_dsg (Hydra, Khronos, Clio), JSON as its 1.1 loads it: keyframes are agent
// nodes, each entity is one Khronos object with its trajectory, floors are layer 5, nodes of any
// other kind have a layer of their own. All edges between two of them are one edge; the
// factors that it stands for are in its metadata. Node ids are (letter << 56) | index.
#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>

#include "dynemo/core/output_file.h"
#include "dynemo/graph/types.h"
#include "dynemo/query/entity_extent.h"
#include "dynemo/query/stays.h"
#include "edge_lines.h"
#include "entity_color.h"
#include "factories.h"

namespace dynemo {

using Json = nlohmann::ordered_json;

namespace {

struct Layer {
  int layer = 0, partition = 0;
  char prefix = 'N';
  std::string name;
};

const Layer kKeyframes{2, 97, 'a', "AGENTS"};
const Layer kEntities{2, 0, 'O', "OBJECTS"};
const Layer kFloors{5, 0, 'F', "FLOORS"};
constexpr int kOtherLayer = 3;

/// Nodes of other kinds: partitions 1, 2, … of layer 3 in the order of the registry.
std::map<std::string, Layer> otherLayers() {
  std::map<std::string, Layer> layers;
  for (const NodeType& type : nodeTypes()) {
    if (type.kind == "keyframe" || type.kind == "entity" || type.kind == "floor") continue;
    Layer layer{kOtherLayer, static_cast<int>(layers.size()) + 1, 'P', ""};
    for (const char c : type.kind)
      layer.name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    layer.name += 'S';
    layer.prefix = layer.name.front();
    layers[type.kind] = layer;
  }
  return layers;
}

std::uint64_t sparkId(const Layer& layer, std::uint64_t index) {
  return static_cast<std::uint64_t>(static_cast<unsigned char>(layer.prefix)) << 56u | index;
}

Json vectorJson(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

Json rotationJson(const Pose3& T) {
  const auto q = T.quaternion();
  return {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}};
}

Json colorJson(std::uint32_t rgb) {
  return {{"r", rgb >> 16u & 255u}, {"g", rgb >> 8u & 255u}, {"b", rgb & 255u}, {"a", 255}};
}

/// Upper triangle, row by row.
Json covarianceJson(const Matrix6& covariance) {
  Json list = Json::array();
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) list.push_back(covariance(r, c));
  return list;
}

Json nodeJson(const Layer& layer, std::uint64_t index, const Json& attributes) {
  return {{"id", sparkId(layer, index)},
          {"layer", layer.layer},
          {"partition", layer.partition},
          {"attributes", attributes}};
}

Json keyframeJson(const CNodeKeyframe& node, const CNodeKeyframe& last) {
  return {{"type", "AgentNodeAttributes"},
          {"metadata",
           {{"frame_index", node.frame_index}, {"reasons", keyframeReasonText(node.reasons)}}},
          {"position", vectorJson(node.T_map_base().t)},
          {"last_update_time_ns", last.stamp.ns},
          {"is_active", false},
          {"is_predicted", false},
          {"timestamp", node.stamp.ns},
          {"world_R_body", rotationJson(node.T_map_base())},
          {"external_key", node.id.value}};
}

Json boxJson(const Pose3& T_map_entity, const Extent& extent) {
  return {{"type", "OBB"},
          {"dimensions", vectorJson(extent.max - extent.min)},
          {"world_P_center", vectorJson(T_map_entity * (0.5 * (extent.min + extent.max)))},
          {"world_R_center", rotationJson(T_map_entity)}};
}

/// What spark_dsg has no field for: full poses, covariances, what moved.
Json entityMetadata(const EntityTrack& track, const std::map<NodeId, Matrix6>& covariances) {
  Json rotations = Json::array(), tangent_covariances = Json::array(), moved = Json::array();
  for (const auto& node : track) {
    const auto q = node->T_map_entity().quaternion();
    rotations.push_back({q.x(), q.y(), q.z(), q.w()});
    const auto covariance = covarianceOf(node->id, covariances);
    tangent_covariances.push_back(covariance ? covarianceJson(*covariance) : Json());
    moved.push_back(node->moved);
  }
  return {{"entity_id", track.front()->entity.value},
          {"class", semanticClassName(track.front()->semantic_class)},
          {"trajectory_quaternions_xyzw", rotations},
          {"trajectory_tangent_covariances", tangent_covariances},
          {"moved_since_previous", moved}};
}

Json entityJson(const RunResult& run, const EntityTrack& track) {
  const CNodeEntity& last = *track.back();
  Json seen_from = Json::array(), seen_to = Json::array(), times = Json::array(),
       positions = Json::array();
  for (const Stay& stay : staysOf(track, run.entity_covariances, QueryParams())) {
    seen_from.push_back(stay.first_seen.ns);
    seen_to.push_back(stay.last_seen.ns);
  }
  for (const auto& node : track) {
    times.push_back(node->stamp.ns);
    positions.push_back(vectorJson(node->T_map_entity().t));
  }
  const Extent extent = extentOf(fragmentPoints(run.graph, track)).value_or(Extent());
  return {{"type", "KhronosObjectAttributes"},
          {"metadata", entityMetadata(track, run.entity_covariances)},
          {"position", vectorJson(last.T_map_entity().t)},
          {"last_update_time_ns", last.stamp.ns},
          {"is_active", false},
          {"is_predicted", false},
          {"name", entityTitle(last)},
          {"color", colorJson(entityRgb(last.entity))},
          {"bounding_box", boxJson(last.T_map_entity(), extent)},
          {"semantic_label", static_cast<int>(last.semantic_class)},
          {"registered", true},
          {"world_R_object", rotationJson(last.T_map_entity())},
          {"first_observed_ns", seen_from},
          {"last_observed_ns", seen_to},
          {"trajectory_timestamps", times},
          {"trajectory_positions", positions}};
}

Json floorJson(const CNodeFloor& floor) {
  return {{"type", "SemanticNodeAttributes"},
          {"metadata", {{"level_m", floor.level_m}}},
          {"position", {floor.center_map_m.x(), floor.center_map_m.y(), floor.level_m}},
          {"name", "floor " + std::to_string(floor.id.value)},
          {"semantic_label", 0}};
}

/// A node of a kind that spark_dsg knows nothing of: its state as numbers.
Json otherJson(const CNodeBase& node, const NodePlaces& places) {
  std::vector<double> state(static_cast<std::size_t>(node.stateSize()));
  node.readState(state.data());
  const auto place = places.find(node.id);
  return {
      {"type", "SemanticNodeAttributes"},
      {"metadata", {{"kind", node.kind()}, {"state", state}}},
      {"position", vectorJson(place == places.end() ? Vector3(Vector3::Zero()) : place->second)},
      {"name", std::string(node.kind()) + " " + std::to_string(node.id.value)},
      {"semantic_label", 0}};
}

class Writer {
 public:
  explicit Writer(const RunResult& run) : run_(run), other_layers_(otherLayers()) {}

  Json json() {
    Json nodes = nodesJson();
    return {{"SPARK_DSG_header",
             {{"project_name", "main"}, {"version", {{"major", 1}, {"minor", 1}, {"patch", 3}}}}},
            {"directed", false},
            {"multigraph", false},
            {"metadata", {{"producer", "dynemo"}, {"frame", "map"}}},
            {"layer_keys", layerKeys()},
            {"layer_names", layerNames()},
            {"nodes", nodes},
            {"edges", edgesJson()}};
  }

 private:
  std::vector<Layer> layers() const {
    std::vector<Layer> all = {kEntities, kKeyframes};
    for (const auto& [kind, layer] : other_layers_) all.push_back(layer);
    all.push_back(kFloors);
    return all;
  }
  static Json keyOf(const Layer& l) { return {{"layer", l.layer}, {"partition", l.partition}}; }
  Json layerKeys() const {
    Json keys = Json::array();
    for (const Layer& l : layers()) keys.push_back(keyOf(l));
    return keys;
  }
  Json layerNames() const {
    Json names;
    for (const Layer& l : layers()) names[l.name] = keyOf(l);
    return names;
  }

  /// Also notes which spark node each of the graph's nodes is part of.
  Json nodesJson() {
    Json nodes = Json::array();
    const auto& graph = run_.graph;
    const NodePlaces places = nodePlaces(graph);
    const auto add = [&](const Layer& layer, std::uint64_t index, const Json& attributes) {
      nodes.push_back(nodeJson(layer, index, attributes));
      return sparkId(layer, index);
    };
    for (const auto& [id, track] : graph.tracks()) {
      const auto spark_id =
          add(kEntities, static_cast<std::uint64_t>(id.value), entityJson(run_, track));
      for (const auto& node : track) spark_of_[node->id] = spark_id;
    }
    for (const auto& slot : graph.nodeSlots()) {
      if (!slot || spark_of_.contains(slot->id)) continue;
      if (const auto* keyframe = dynamic_cast<const CNodeKeyframe*>(slot.get())) {
        spark_of_[slot->id] =
            add(kKeyframes, slot->id.value, keyframeJson(*keyframe, *graph.keyframes().back()));
      } else if (const auto* floor = dynamic_cast<const CNodeFloor*>(slot.get())) {
        spark_of_[slot->id] = add(kFloors, slot->id.value, floorJson(*floor));
      } else {
        spark_of_[slot->id] =
            add(other_layers_.at(slot->kind()), slot->id.value, otherJson(*slot, places));
      }
    }
    return nodes;
  }

  /// spark_dsg takes one undirected edge per pair and none from a node to itself.
  Json edgesJson() const {
    std::map<std::pair<std::uint64_t, std::uint64_t>, std::map<std::string, int>> factors;
    for (const auto& edge : run_.graph.edgeSlots()) {
      for (std::size_t i = 1; edge && i < edge->nodes.size(); ++i) {
        const auto a = spark_of_.at(edge->nodes[i - 1]), b = spark_of_.at(edge->nodes[i]);
        if (a != b) ++factors[std::minmax(a, b)][edge->kind()];
      }
    }
    addFloors(factors);
    Json edges = Json::array();
    for (const auto& [pair, kinds] : factors) {
      int count = 0;
      for (const auto& [kind, n] : kinds) count += n;
      edges.push_back({{"source", pair.first},
                       {"target", pair.second},
                       {"info",
                        {{"type", "EdgeAttributes"},
                         {"weighted", true},
                         {"weight", static_cast<double>(std::max(1, count))},
                         {"metadata", {{"factors", kinds}}}}}});
    }
    return edges;
  }

  /// The hierarchy: keyframes are on their floor.
  void addFloors(
      std::map<std::pair<std::uint64_t, std::uint64_t>, std::map<std::string, int>>& edges) const {
    for (const auto& keyframe : run_.graph.keyframes()) {
      if (!keyframe->floor) continue;
      const auto floor = spark_of_.find(*keyframe->floor);
      if (floor == spark_of_.end()) continue;
      edges[std::minmax(spark_of_.at(keyframe->id), std::uint64_t{floor->second})];
    }
  }

  const RunResult& run_;
  std::map<std::string, Layer> other_layers_;
  std::map<NodeId, std::uint64_t> spark_of_;
};

class SparkDsgExporter : public Exporter {
 public:
  std::string fileName() const override { return "scene_graph.json"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    writeFileAtomically(
        file, Writer(run).json().dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
  }
};

}  // namespace

std::unique_ptr<Exporter> makeSparkDsgExporter(const ExportParams&) {
  return std::make_unique<SparkDsgExporter>();
}

}  // namespace dynemo
