// Every registered class survives storage to the byte, and damaged bytes end in an exception at
// worst.
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include "dynemo/graph/scene_graph.h"
#include "registered_types.h"

namespace dynemo::test {
namespace {

using mrpt::serialization::archiveFrom;
using mrpt::serialization::CSerializable;
using Bytes = std::string;

Bytes save(const CSerializable& object) {
  mrpt::io::CMemoryStream stream;
  auto archive = archiveFrom(stream);
  archive << object;
  return {static_cast<const char*>(stream.getRawBufferData()), stream.getTotalBytesCount()};
}

CSerializable::Ptr load(const Bytes& bytes) {
  mrpt::io::CMemoryStream stream(bytes.data(), bytes.size());
  auto archive = archiveFrom(stream);
  return archive.ReadObject();
}

/// Loads bytes that may be damaged; whatever comes of it must be an object or an exception.
void loadDamaged(const Bytes& bytes) {
  try {
    load(bytes);
  } catch (const std::exception&) {
  }
}

void expectRoundTrip(const CSerializable& object) {
  const Bytes first = save(object);
  const auto copy = load(first);
  ASSERT_TRUE(copy);
  EXPECT_STREQ(copy->GetRuntimeClass()->className, object.GetRuntimeClass()->className);
  EXPECT_EQ(save(*copy), first);
}

void expectDamageIsHarmless(const Bytes& bytes, std::mt19937_64& rng) {
  for (std::size_t n = 0; n < bytes.size(); n += 1 + bytes.size() / 300) {
    EXPECT_ANY_THROW(load(bytes.substr(0, n))) << "cut to " << n << " bytes";
  }
  for (int i = 0; i < 2000; ++i) {
    Bytes damaged = bytes;
    for (std::uint64_t hits = 1 + rng() % 3; hits > 0; --hits) {
      damaged[rng() % damaged.size()] = static_cast<char>(rng());
    }
    loadDamaged(damaged);
  }
  // Lengths and counts are where a wrong value hurts most.
  for (std::size_t at = 0; at + 4 <= bytes.size() && at < 2000; ++at) {
    Bytes damaged = bytes;
    damaged.replace(at, 4, "\xff\xff\xff\x7f");
    loadDamaged(damaged);
  }
}

class StoredNodes : public ::testing::TestWithParam<NodeType> {
 protected:
  void SetUp() override { registerGraphClasses(); }
  std::mt19937_64 rng_{99};
};

CNodeBase::Ptr filledIn(const NodeType& type, std::mt19937_64& rng) {
  auto node = type.example(rng);
  node->id = {rng()};
  if (auto* keyframe = dynamic_cast<CNodeKeyframe*>(node.get())) {
    keyframe->stamp = {static_cast<std::int64_t>(rng())};
    keyframe->frame_index = rng();
    keyframe->T_odom_base = randomPose(rng);
    keyframe->reasons = 10;
    if (rng() % 2) keyframe->floor = NodeId{rng()};
  } else if (auto* entity = dynamic_cast<CNodeEntity*>(node.get())) {
    entity->entity = {-3};
    entity->name = "chair, third";
    entity->semantic_class = SemanticClass::kAgent;
    entity->keyframe = {rng()};
    entity->stamp = {static_cast<std::int64_t>(rng())};
    entity->moved = true;
    entity->fragment = {1, 5, 4'000'000'000u};
  }
  return node;
}

TEST_P(StoredNodes, SurviveToTheByte) {
  for (int i = 0; i < 20; ++i) expectRoundTrip(*filledIn(GetParam(), rng_));
}

TEST_P(StoredNodes, KeepTheirEstimateAndId) {
  const auto node = filledIn(GetParam(), rng_);
  const auto copy = std::dynamic_pointer_cast<CNodeBase>(load(save(*node)));
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->id, node->id);
  std::vector<double> a(static_cast<std::size_t>(node->stateSize())), b(a.size());
  node->readState(a.data());
  copy->readState(b.data());
  EXPECT_EQ(a, b);
}

TEST_P(StoredNodes, DamageIsHarmless) {
  expectDamageIsHarmless(save(*filledIn(GetParam(), rng_)), rng_);
}

INSTANTIATE_TEST_SUITE_P(Registry, StoredNodes, ::testing::ValuesIn(nodeTypes()), KindName());

class StoredEdges : public ::testing::TestWithParam<EdgeType> {
 protected:
  void SetUp() override { registerGraphClasses(); }
  CEdgeBase::Ptr example() {
    auto edge = GetParam().example(rng_);
    edge->id = {rng_()};
    for (std::size_t i = 0; i < GetParam().node_kinds.size(); ++i) edge->nodes.push_back({rng_()});
    edge->kernel = {KernelType::kCauchy, 2.5};
    return edge;
  }
  std::mt19937_64 rng_{100};
};

TEST_P(StoredEdges, SurviveToTheByte) {
  for (int i = 0; i < 20; ++i) expectRoundTrip(*example());
}

TEST_P(StoredEdges, KeepTheirResidualAndWeight) {
  const auto edge = example();
  const auto copy = std::dynamic_pointer_cast<CEdgeBase>(load(save(*edge)));
  ASSERT_TRUE(copy);
  const auto nodes = examplesFor(GetParam(), rng_);
  EXPECT_EQ(residualAt(*copy, States(nodes)), residualAt(*edge, States(nodes)));
  EXPECT_EQ(copy->information(), edge->information());
  EXPECT_EQ(copy->nodes, edge->nodes);
  EXPECT_EQ(copy->kernel.type, edge->kernel.type);
  EXPECT_EQ(copy->kernel.width, edge->kernel.width);
}

TEST_P(StoredEdges, DamageIsHarmless) { expectDamageIsHarmless(save(*example()), rng_); }

INSTANTIATE_TEST_SUITE_P(Registry, StoredEdges, ::testing::ValuesIn(edgeTypes()), KindName());

/// A node of every kind and an edge of every kind; with a removed edge.
CSceneGraph smallGraph(std::mt19937_64& rng) {
  CSceneGraph graph;
  GraphDelta delta;
  std::map<std::string, std::vector<NodeId>> by_kind;
  for (int copy = 0; copy < 3; ++copy) {
    for (const NodeType& type : nodeTypes()) {
      auto node = filledIn(type, rng);
      node->id = {delta.nodes.size()};
      by_kind[type.kind].push_back(node->id);
      delta.nodes.push_back(node);
    }
  }
  for (const EdgeType& type : edgeTypes()) {
    auto edge = type.example(rng);
    edge->id = {delta.edges.size()};
    std::map<std::string, std::size_t> used;
    for (const std::string& kind : type.node_kinds)
      edge->nodes.push_back(by_kind[kind].at(used[kind]++));
    delta.edges.push_back(edge);
  }
  graph.apply(delta);
  GraphDelta removal;
  removal.removed_edges = {EdgeId{2}};
  graph.apply(removal);
  graph.T_map_odom = randomPose(rng);
  return graph;
}

class StoredGraph : public ::testing::Test {
 protected:
  void SetUp() override { registerGraphClasses(); }
  std::mt19937_64 rng_{5};
};

TEST_F(StoredGraph, SurvivesToTheByteWithItsCost) {
  const CSceneGraph graph = smallGraph(rng_);
  expectRoundTrip(graph);
  const auto copy = std::dynamic_pointer_cast<CSceneGraph>(load(save(graph)));
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->totalCost(), graph.totalCost());
  EXPECT_EQ(copy->nodeCount(), graph.nodeCount());
  EXPECT_EQ(copy->edgeCount(), graph.edgeCount());
  EXPECT_EQ(copy->nextEdgeId(), graph.nextEdgeId());
  EXPECT_EQ(copy->keyframes().size(), graph.keyframes().size());
  EXPECT_EQ(copy->tracks().size(), graph.tracks().size());
  EXPECT_EQ(copy->topology().edges.size(), graph.topology().edges.size());
}

TEST_F(StoredGraph, DamageIsHarmless) { expectDamageIsHarmless(save(smallGraph(rng_)), rng_); }

TEST_F(StoredGraph, DamagedOneThatStillLoadsCanBeUsed) {
  const Bytes bytes = save(smallGraph(rng_));
  int loaded = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes damaged = bytes;
    damaged[rng_() % damaged.size()] = static_cast<char>(rng_());
    try {
      const auto graph = std::dynamic_pointer_cast<CSceneGraph>(load(damaged));
      if (!graph) continue;
      ++loaded;
      // Reads every state through every edge: a wrong node behind an edge would show under the
      // sanitizers.
      (void)graph->totalCost();
      for (const auto& node : graph->nodeSlots()) {
        if (node) (void)graph->edgesOf(node->id);
      }
    } catch (const std::exception&) {
    }
  }
  EXPECT_GT(loaded, 0) << "most flipped bits are in numbers";
}

}  // namespace
}  // namespace dynemo::test
