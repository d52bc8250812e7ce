// The parts of a glTF 2.0 asset (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html):
// meshes, a tree of nodes, animations, and one binary buffer.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"

namespace dynemo {

/// Colour in sRGB, as pictures have it: 0xRRGGBB, opacity in [0, 1].
struct GltfColor {
  std::uint32_t rgb = 0xffffff;
  double opacity = 1.0;
};

enum class GltfMode { kPoints = 0, kLines = 1, kLineStrip = 3, kTriangles = 4 };

struct GltfMesh {
  std::string name;
  GltfMode mode = GltfMode::kTriangles;
  std::vector<Eigen::Vector3f> positions;
  /// Per vertex, 0xRRGGBB; empty for the colour of the material alone.
  std::vector<std::uint32_t> colors;
  GltfColor material;
};

class GltfBuilder {
 public:
  using Json = nlohmann::ordered_json;

  GltfBuilder();

  /// Returns the mesh's index. A mesh has at least one position.
  int addMesh(const GltfMesh& mesh);

  /// A node below another one (the root when none is given), optionally with a mesh and free data.
  struct Node {
    std::string name;
    std::optional<int> parent, mesh;
    std::optional<Pose3> T_parent_node;
    Json extras;
  };
  int addNode(const Node& node);

  /// Moves a node. Times ascend strictly [s]; `stepwise` holds each pose until the next.
  void animate(int node, const std::vector<double>& times_s, const std::vector<Pose3>& poses,
               bool stepwise);

  /// The whole asset in one file: binary (.glb), or JSON with the buffer inside (.gltf).
  std::string glb() const;
  std::string gltf() const;

 private:
  int addView(const std::string& bytes, std::optional<int> target);
  int addAccessor(int view, int component_type, std::size_t count, const char* type,
                  bool normalized = false);
  int addPositions(const std::vector<Eigen::Vector3f>& positions);
  int addColors(const std::vector<std::uint32_t>& colors);
  int addMaterial(const GltfColor& color);
  Json assembled(const std::string& uri) const;

  std::string buffer_;
  Json views_ = Json::array(), accessors_ = Json::array(), meshes_ = Json::array(),
       materials_ = Json::array(), nodes_ = Json::array(), samplers_ = Json::array(),
       channels_ = Json::array();
};

}  // namespace dynemo
