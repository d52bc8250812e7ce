// The glTF file, taken apart by a reader of the test's own; the Khronos validator judges the
// exported sample elsewhere.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "base64.h"
#include "dynemo/exporters/exporter.h"
#include "dynemo/graph/types.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

using Json = nlohmann::json;

struct Glb {
  Json json;
  std::string buffer;
};

std::uint32_t word(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

Glb readGlb(const std::string& bytes) {
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word(bytes, 4), 2u);
  EXPECT_EQ(word(bytes, 8), bytes.size());
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  const std::size_t length = word(bytes, 12);
  Glb glb{Json::parse(bytes.substr(20, length)), ""};
  if (20 + length < bytes.size()) glb.buffer = bytes.substr(28 + length);
  return glb;
}

const Json& nodeNamed(const Json& json, const std::string& name) {
  for (const Json& node : json.at("nodes")) {
    if (node.at("name") == name) return node;
  }
  throw std::runtime_error("no node " + name);
}

std::vector<float> floatsOf(const Glb& glb, const Json& accessor) {
  const Json& view = glb.json.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  const std::size_t size = view.at("byteLength"), at = view.at("byteOffset");
  std::vector<float> values(size / 4);
  std::memcpy(values.data(), glb.buffer.data() + at, size);
  return values;
}

TEST(Gltf, HasALayerPerKindOfThing) {
  const SmallRun run = smallRun();
  const Glb glb = readGlb(exported("gltf", run.result()));
  for (const char* name : {"map points", "structure", "entity fragments", "floors", "floor 2",
                           "edges", "odometry", "loop_closure", "keyframes", "keyframe 5", "robot",
                           "base", "entities", "walker 101", "box, \"red\" 7"})
    EXPECT_NO_THROW(nodeNamed(glb.json, name)) << name;
  EXPECT_EQ(nodeNamed(glb.json, "keyframe 5").at("extras").at("node"), 5);
}

TEST(Gltf, StandsUprightWithTheKeyframesWhereTheyAre) {
  const SmallRun run = smallRun();
  const Glb glb = readGlb(exported("gltf", run.result()));
  const Json& root = glb.json.at("nodes").at(0);
  const auto r = root.at("rotation").get<std::vector<double>>();
  const Eigen::Quaterniond q(r[3], r[0], r[1], r[2]);
  EXPECT_LT((q * Vector3::UnitZ() - Vector3::UnitY()).norm(), 1e-12);
  const auto t = nodeNamed(glb.json, "keyframe 5").at("translation").get<std::vector<double>>();
  EXPECT_EQ(Vector3(t[0], t[1], t[2]), run.graph.getNode<CNodePose>({5}).T_map_node.t);
}

TEST(Gltf, AnimatesWhatMoves) {
  const SmallRun run = smallRun();
  const Glb glb = readGlb(exported("gltf", run.result()));
  const Json& animation = glb.json.at("animations").at(0);
  std::set<std::string> moved;
  for (const Json& channel : animation.at("channels")) {
    const std::size_t node = channel.at("target").at("node"), sampler = channel.at("sampler");
    moved.insert(glb.json.at("nodes").at(node).at("name"));
    const Json& s = animation.at("samplers").at(sampler);
    const auto times = floatsOf(glb, glb.json.at("accessors").at(s.at("input").get<std::size_t>()));
    for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i], times[i - 1]);
  }
  EXPECT_EQ(moved, (std::set<std::string>{"base", "box, \"red\" 7 box"}));
}

TEST(Gltf, TextAndBinaryHoldTheSame) {
  const SmallRun run = smallRun();
  const TemporaryFolder folder;
  const auto exporter = exporters().make("gltf", ExportParams());
  exporter->write(run.result(), folder.path() / "scene.gltf");
  Json text = Json::parse(readFile(folder.path() / "scene.gltf"));
  const Glb glb = readGlb(exported("gltf", run.result()));
  const std::size_t length = text.at("buffers").at(0).at("byteLength");
  EXPECT_EQ(text.at("buffers").at(0).at("uri"),
            "data:application/octet-stream;base64," + base64(glb.buffer.substr(0, length)));
  text.at("buffers").at(0).erase("uri");
  EXPECT_EQ(text, glb.json);
}

TEST(Base64, OfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

}  // namespace
}  // namespace dynemo::test
