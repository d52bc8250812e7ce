#include "gltf_builder.h"

#include <cmath>

#include "base64.h"
#include "binary_text.h"

namespace dynemo {

using Json = GltfBuilder::Json;

namespace {

constexpr int kUnsignedByte = 5121, kFloat = 5126;
constexpr int kVertexData = 34962;

/// glTF colours are linear.
double linear(std::uint32_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

Json linearColor(const GltfColor& color) {
  return {linear(color.rgb >> 16u & 255u), linear(color.rgb >> 8u & 255u), linear(color.rgb & 255u),
          color.opacity};
}

void pad(std::string& bytes, char filler) {
  while (bytes.size() % 4 != 0) bytes += filler;
}

/// Names that are no UTF-8 do not break the file.
std::string text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json floats(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

GltfBuilder::GltfBuilder() {
  // glTF's y is up; ours is z.
  const double half = std::sqrt(0.5);
  nodes_.push_back({{"name", "dynemo"}, {"rotation", {-half, 0.0, 0.0, half}}});
}

int GltfBuilder::addView(const std::string& bytes, std::optional<int> target) {
  Json view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
  if (target) view["target"] = *target;
  views_.push_back(view);
  buffer_ += bytes;
  pad(buffer_, '\0');
  return static_cast<int>(views_.size()) - 1;
}

int GltfBuilder::addAccessor(int view, int component_type, std::size_t count, const char* type,
                             bool normalized) {
  Json accessor = {
      {"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}};
  if (normalized) accessor["normalized"] = true;
  accessors_.push_back(accessor);
  return static_cast<int>(accessors_.size()) - 1;
}

int GltfBuilder::addPositions(const std::vector<Eigen::Vector3f>& positions) {
  std::string bytes;
  Eigen::Vector3f min = positions.front(), max = positions.front();
  for (const auto& p : positions) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, p[axis]);
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  const int accessor = addAccessor(addView(bytes, kVertexData), kFloat, positions.size(), "VEC3");
  accessors_.back()["min"] = floats(min);
  accessors_.back()["max"] = floats(max);
  return accessor;
}

int GltfBuilder::addColors(const std::vector<std::uint32_t>& colors) {
  std::string bytes;
  for (const std::uint32_t rgb : colors) {
    for (const unsigned shift : {16u, 8u, 0u}) {
      append(bytes, static_cast<std::uint8_t>(std::lround(255.0 * linear(rgb >> shift & 255u))));
    }
    append(bytes, std::uint8_t{255});
  }
  return addAccessor(addView(bytes, kVertexData), kUnsignedByte, colors.size(), "VEC4", true);
}

int GltfBuilder::addMaterial(const GltfColor& color) {
  // Unlit: colours mean something here.
  Json material = {
      {"pbrMetallicRoughness", {{"baseColorFactor", linearColor(color)}, {"metallicFactor", 0.0}}},
      {"doubleSided", true},
      {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
  if (color.opacity < 1.0) material["alphaMode"] = "BLEND";
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    if (materials_[i] == material) return static_cast<int>(i);
  }
  materials_.push_back(material);
  return static_cast<int>(materials_.size()) - 1;
}

int GltfBuilder::addMesh(const GltfMesh& mesh) {
  Json attributes = {{"POSITION", addPositions(mesh.positions)}};
  if (!mesh.colors.empty()) attributes["COLOR_0"] = addColors(mesh.colors);
  meshes_.push_back({{"name", mesh.name},
                     {"primitives", Json::array({{{"attributes", attributes},
                                                  {"mode", static_cast<int>(mesh.mode)},
                                                  {"material", addMaterial(mesh.material)}}})}});
  return static_cast<int>(meshes_.size()) - 1;
}

int GltfBuilder::addNode(const Node& node) {
  Json json = {{"name", node.name}};
  if (node.mesh) json["mesh"] = *node.mesh;
  if (node.T_parent_node) {
    const Pose3& T = *node.T_parent_node;
    const auto q = T.quaternion();
    json["translation"] = {T.t.x(), T.t.y(), T.t.z()};
    json["rotation"] = {q.x(), q.y(), q.z(), q.w()};
  }
  if (!node.extras.is_null()) json["extras"] = node.extras;
  const auto index = static_cast<int>(nodes_.size());
  nodes_.push_back(json);
  nodes_[static_cast<std::size_t>(node.parent.value_or(0))]["children"].push_back(index);
  return index;
}

void GltfBuilder::animate(int node, const std::vector<double>& times_s,
                          const std::vector<Pose3>& poses, bool stepwise) {
  std::string times, translations, rotations;
  for (const double t : times_s) append(times, static_cast<float>(t));
  Eigen::Vector4d last = Eigen::Vector4d::Zero();
  for (const Pose3& T : poses) {
    for (int axis = 0; axis < 3; ++axis) append(translations, static_cast<float>(T.t[axis]));
    Eigen::Vector4d q = T.quaternion().coeffs();
    if (q.dot(last) < 0.0) q = -q;  // the short way round
    last = q;
    for (int i = 0; i < 4; ++i) append(rotations, static_cast<float>(q[i]));
  }
  const int input = addAccessor(addView(times, {}), kFloat, times_s.size(), "SCALAR");
  accessors_.back()["min"] = {static_cast<float>(times_s.front())};
  accessors_.back()["max"] = {static_cast<float>(times_s.back())};
  const auto addChannel = [&](const std::string& bytes, const char* type, const char* path) {
    const int output = addAccessor(addView(bytes, {}), kFloat, poses.size(), type);
    samplers_.push_back(
        {{"input", input}, {"interpolation", stepwise ? "STEP" : "LINEAR"}, {"output", output}});
    channels_.push_back(
        {{"sampler", samplers_.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  };
  addChannel(translations, "VEC3", "translation");
  addChannel(rotations, "VEC4", "rotation");
}

Json GltfBuilder::assembled(const std::string& uri) const {
  Json buffer = {{"byteLength", buffer_.size()}};
  if (!uri.empty()) buffer["uri"] = uri;
  Json json = {{"asset", {{"version", "2.0"}, {"generator", "dynemo"}}},
               {"extensionsUsed", {"KHR_materials_unlit"}},
               {"scene", 0},
               {"scenes", Json::array({{{"nodes", {0}}}})},
               {"nodes", nodes_}};
  // Empty lists are not allowed.
  const auto add = [&json](const char* key, const Json& list) {
    if (!list.empty()) json[key] = list;
  };
  add("meshes", meshes_);
  add("materials", materials_);
  add("accessors", accessors_);
  add("bufferViews", views_);
  if (!buffer_.empty()) json["buffers"] = Json::array({buffer});
  if (!channels_.empty()) {
    json["animations"] =
        Json::array({{{"name", "run"}, {"channels", channels_}, {"samplers", samplers_}}});
  }
  if (materials_.empty()) json.erase("extensionsUsed");
  return json;
}

std::string GltfBuilder::glb() const {
  std::string json = text(assembled("")), bytes = "glTF";
  pad(json, ' ');
  const std::size_t buffer_chunk = buffer_.empty() ? 0 : 8 + buffer_.size();
  append(bytes, std::uint32_t{2});
  append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + buffer_chunk));
  append(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  if (buffer_.empty()) return bytes;
  append(bytes, static_cast<std::uint32_t>(buffer_.size()));
  bytes.append("BIN\0", 4);
  return bytes + buffer_;
}

std::string GltfBuilder::gltf() const {
  return text(assembled("data:application/octet-stream;base64," + base64(buffer_))) + '\n';
}

}  // namespace dynemo
