#include "dynemo/life/removal.h"

#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <Eigen/Eigenvalues>
#include <set>

#include "connection.h"
#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_summary.h"
#include "dynemo/graph/types.h"
#include "generated_graph.h"
#include "local_marginal.h"

namespace dynemo {
namespace {

using test::GeneratedWorld;
using test::WorldParams;

SolverParams tight() {
  SolverParams params;
  params.method = SolverParams::Method::kBatch;
  params.min_relative_decrease = 1e-12;
  return params;
}

void optimize(CSceneGraph& graph) {
  const OptimizationReport report = Optimizer(tight()).optimize(graph);
  ASSERT_TRUE(report.usable()) << report.message;
}

std::string bytesOf(const CSceneGraph& graph) {
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  archive << graph;
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<std::size_t>(memory.getTotalBytesCount())};
}

CSceneGraph graphFrom(const std::string& bytes) {
  registerGraphClasses();
  mrpt::io::CMemoryStream memory(bytes.data(), bytes.size());
  auto archive = mrpt::serialization::archiveFrom(memory);
  CSceneGraph graph;
  archive >> graph;
  return graph;
}

/// Some keyframes of a lap: neither the first sighting of anything nor the last.
std::vector<NodeId> inTheMiddle(const CSceneGraph& graph, std::size_t from, std::size_t to) {
  std::vector<NodeId> ids;
  for (std::size_t k = from; k < to; ++k) ids.push_back(graph.keyframes()[k]->id);
  return ids;
}

void remove(CSceneGraph& graph, const std::vector<NodeId>& keyframes) {
  for (const NodeId id : keyframes) graph.apply(removalOf(graph, id, {}));
}

double largestDifference_m(const CSceneGraph& a, const CSceneGraph& b) {
  double largest = 0.0;
  for (const auto& keyframe : b.keyframes()) {
    const Pose3& T_a = a.getNode<CNodeKeyframe>(keyframe->id).T_map_base();
    largest = std::max(largest, (T_a.t - keyframe->T_map_base().t).norm());
  }
  return largest;
}

/// A closure that bends a graph: between two of its keyframes, and 0.1 m off.
void bend(CSceneGraph& graph, NodeId from, NodeId to) {
  GraphDelta delta;
  auto edge = std::make_shared<CEdgeLoopClosure>();
  edge->id = graph.nextEdgeId();
  edge->nodes = {from, to};
  const Pose3& T_map_from = graph.getNode<CNodeKeyframe>(from).T_map_base();
  const Pose3& T_map_to = graph.getNode<CNodeKeyframe>(to).T_map_base();
  edge->T_1_2 = T_map_from.inverse() * T_map_to * Pose3::translation(0.1, -0.05, 0.02);
  edge->setCovariance(isotropicCovariance(0.05, 0.02));
  delta.edges.push_back(edge);
  graph.apply(delta);
}

/// Keyframes tied by odometry alone.
CSceneGraph chain(std::size_t keyframes) {
  std::mt19937_64 rng(7);
  CSceneGraph graph;
  for (std::size_t k = 0; k < keyframes; ++k) {
    GraphDelta delta;
    auto node = std::make_shared<CNodeKeyframe>();
    node->id = graph.nextNodeId();
    node->T_map_node = Pose3::fromYawPitchRoll(0.8 * static_cast<double>(k), 0, 0,
                                               0.2 * static_cast<double>(k), 0.02, 0.01);
    delta.nodes.push_back(node);
    if (k == 0) {
      auto prior = std::make_shared<CEdgePosePrior>();
      prior->id = graph.nextEdgeId();
      prior->nodes = {node->id};
      prior->T_map_node = node->T_map_node;
      prior->setCovariance(isotropicCovariance(1e-3, 1e-3));
      delta.edges.push_back(prior);
    } else {
      auto edge = std::make_shared<CEdgeOdometry>();
      edge->id = graph.nextEdgeId();
      edge->nodes = {graph.keyframes().back()->id, node->id};
      edge->T_1_2 = graph.keyframes().back()->T_map_base().inverse() * node->T_map_node;
      edge->setInformation(1e3 * randomInformation(6, rng));
      delta.edges.push_back(edge);
    }
    graph.apply(delta);
  }
  return graph;
}

TEST(Removal, OfALinkOfAChainIsExact) {
  CSceneGraph full = chain(12), reduced = chain(12);
  remove(reduced, inTheMiddle(full, 3, 8));
  ASSERT_EQ(reduced.keyframes().size(), 7u);
  ASSERT_EQ(reduced.edgeCount(), 7u) << "the prior and six links";
  // Both answer a closure in the same way.
  const NodeId from = full.keyframes()[1]->id, to = full.keyframes()[10]->id;
  for (CSceneGraph* graph : {&full, &reduced}) {
    bend(*graph, from, to);
    optimize(*graph);
  }
  EXPECT_GT(largestDifference_m(chain(12), reduced), 0.03) << "the closure must bend the chain";
  EXPECT_LT(largestDifference_m(full, reduced), 3e-3);
  EXPECT_NEAR(full.totalCost(), reduced.totalCost(), 0.02 * full.totalCost());
}

class RemovalFromAMap : public testing::TestWithParam<std::uint64_t> {
 protected:
  void SetUp() override {
    graph_ = test::generateGraph({.seed = GetParam()}, 150);
    optimize(graph_);
  }
  CSceneGraph graph_;
};

TEST_P(RemovalFromAMap, LeavesTheMinimumWhereItIs) {
  const CSceneGraph before = graphFrom(bytesOf(graph_));
  remove(graph_, inTheMiddle(before, 70, 84));
  EXPECT_EQ(graph_.keyframes().size(), 136u);
  optimize(graph_);
  // Pairs cannot say all that the keyframes said: less than the noise of what they saw (0.03 m).
  EXPECT_LT(largestDifference_m(before, graph_), 0.02);
}

TEST_P(RemovalFromAMap, KnowsAsMuchAsBefore) {
  // Without objects: one that has not moved is where it was, more firmly than a chain of its
  // observations says.
  graph_ = test::generateGraph({.seed = GetParam(), .observations_per_keyframe = 1}, 150);
  optimize(graph_);
  const std::vector<NodeId> leaving = inTheMiddle(graph_, 70, 84);
  const std::set<NodeId> gone(leaving.begin(), leaving.end());
  std::vector<NodeId> staying;
  for (const auto& keyframe : graph_.keyframes())
    if (!gone.contains(keyframe->id)) staying.push_back(keyframe->id);
  const auto before = Optimizer(tight()).marginalCovariance(graph_, staying);
  remove(graph_, leaving);
  const auto after = Optimizer(tight()).marginalCovariance(graph_, staying);
  ASSERT_TRUE(before && after);
  // Pairs cannot tell all that is correlated: in no direction is a tenth of the deviation lost.
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> ratio(*after, *before,
                                                                Eigen::EigenvaluesOnly);
  EXPECT_GT(std::sqrt(ratio.eigenvalues().minCoeff()), 0.9);
  EXPECT_NEAR(std::sqrt(after->trace() / before->trace()), 1.0, 0.03);
}

/// The odometry between two keyframes, or null.
const CEdgeOdometry* odometry(const CSceneGraph& graph, NodeId before, NodeId after) {
  for (const EdgeId id : graph.edgesOf(after)) {
    const auto* edge = dynamic_cast<const CEdgeOdometry*>(graph.edgeSlots()[id.value].get());
    if (edge && edge->nodes == std::vector<NodeId>{before, after}) return edge;
  }
  return nullptr;
}

TEST_P(RemovalFromAMap, KeepsTheOdometryAsLongAsItSaysSomething) {
  const auto& keyframes = graph_.keyframes();
  const NodeId before = keyframes[69]->id, soon = keyframes[71]->id, late = keyframes[84]->id;
  remove(graph_, inTheMiddle(graph_, 70, 71));
  ASSERT_TRUE(odometry(graph_, before, soon));
  remove(graph_, inTheMiddle(graph_, 70, 83));
  EXPECT_EQ(keyframes[70]->id, late);
  EXPECT_FALSE(odometry(graph_, before, late)) << "more than a decimetre and a half off";
  EXPECT_TRUE(life::isConnected(graph_, before, late, {}, {}));
}

TEST_P(RemovalFromAMap, LeavesNoNodeWithoutAnEdge) {
  remove(graph_, inTheMiddle(graph_, 70, 84));
  for (const auto& node : graph_.nodeSlots())
    EXPECT_FALSE(graph_.edgesOf(node->id).empty()) << node->kind() << " " << node->id;
}

TEST_P(RemovalFromAMap, KeepsWhatWasSeenOfWalls) {
  const auto points = [](const CSceneGraph& graph) {
    std::size_t sum = 0;
    for (const auto& edge : graph.edgeSlots()) {
      const auto* seen = dynamic_cast<const CEdgeKeyframePlane*>(edge.get());
      if (seen) sum += seen->point_count;
    }
    return sum;
  };
  const auto before = static_cast<double>(points(graph_));
  remove(graph_, inTheMiddle(graph_, 70, 84));
  // What is said too vaguely is forgotten.
  EXPECT_GT(static_cast<double>(points(graph_)), 0.9 * before);
}

TEST_P(RemovalFromAMap, IsReadBackAsItWasWritten) {
  remove(graph_, inTheMiddle(graph_, 70, 84));
  bool has_summary = false;
  for (const auto& edge : graph_.edgeSlots())
    has_summary |= edge && std::string(edge->kind()) == "summary";
  EXPECT_TRUE(has_summary);
  const std::string bytes = bytesOf(graph_);
  EXPECT_EQ(bytesOf(graphFrom(bytes)), bytes);
}

TEST_P(RemovalFromAMap, TwiceGivesTheSameBytes) {
  CSceneGraph other = graphFrom(bytesOf(graph_));
  remove(graph_, inTheMiddle(graph_, 70, 84));
  remove(other, inTheMiddle(other, 70, 84));
  EXPECT_EQ(bytesOf(graph_), bytesOf(other));
}

TEST_P(RemovalFromAMap, TheIncrementalSolverFollows) {
  Optimizer incremental{SolverParams()};
  ASSERT_TRUE(incremental.optimize(graph_).usable());
  remove(graph_, inTheMiddle(graph_, 70, 84));
  ASSERT_TRUE(incremental.optimize(graph_).usable());
  const double cost = graph_.totalCost();
  EXPECT_LT(cost, 1.001 * incremental.optimizeFully(graph_).cost_after);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RemovalFromAMap, testing::Values(1, 2));

TEST(Removal, AnUnmovedObjectIsTiedToWhereItWasBefore) {
  CSceneGraph graph = test::generateGraph({}, 150);
  optimize(graph);
  const NodeId leaving = graph.keyframes()[100]->id;
  const auto track = std::find_if(graph.tracks().begin(), graph.tracks().end(), [&](const auto& t) {
    return t.second.front()->semantic_class == SemanticClass::kObject &&
           std::any_of(t.second.begin(), t.second.end(),
                       [&](const auto& node) { return node->keyframe == leaving; });
  });
  ASSERT_NE(track, graph.tracks().end());
  const EntityId entity = track->first;
  std::size_t i = 0;
  while (track->second[i]->keyframe != leaving) ++i;
  ASSERT_TRUE(i > 0 && i + 1 < track->second.size());
  const NodeId before = track->second[i - 1]->id, after = track->second[i + 1]->id;
  const std::size_t observations = track->second.size();

  graph.apply(removalOf(graph, leaving, {}));
  EXPECT_EQ(graph.tracks().at(entity).size(), observations - 1);
  const CEdgeIntraEntity* tie = nullptr;
  for (const EdgeId id : graph.edgesOf(after)) {
    const auto* edge = dynamic_cast<const CEdgeIntraEntity*>(graph.edgeSlots()[id.value].get());
    if (edge && edge->nodes[0] == before) tie = edge;
  }
  ASSERT_TRUE(tie);
  // As firmly as two consecutive observations (generated_graph.cpp).
  const MatrixX expected = *invertSpd(isotropicCovariance(0.02, 0.035));
  EXPECT_LT((tie->information() - expected).norm(), 1e-9 * expected.norm());
}

TEST(Removal, AKeyframeWithAPriorMustStay) {
  const CSceneGraph graph = test::generateGraph({}, 20);
  EXPECT_THROW(removalOf(graph, graph.keyframes().front()->id, {}), std::logic_error);
  EXPECT_THROW(removalOf(graph, NodeId{1'000'000}, {}), std::out_of_range);
  EXPECT_THROW(removalOf(graph, graph.floors().front()->id, {}), std::out_of_range);
}

TEST(Removal, WhatSaysLittleIsForgotten) {
  CSceneGraph graph = test::generateGraph({}, 150);
  optimize(graph);
  LifeParams forgetful;
  forgetful.weakest_sigma_m = 1e-4;
  const NodeId leaving = graph.keyframes()[75]->id;
  const GraphDelta all = removalOf(graph, leaving, {}),
                   least = removalOf(graph, leaving, forgetful);
  EXPECT_LT(least.edges.size(), all.edges.size());
  EXPECT_TRUE(std::any_of(least.edges.begin(), least.edges.end(), [](const auto& edge) {
    return dynamic_cast<const CEdgeOdometry*>(edge.get()) != nullptr;
  })) << "which ties neighbours";
}

TEST(LocalMarginal, IsRelative) {
  const CSceneGraph graph = test::generateGraph({}, 40);
  // Of a keyframe that sees neither the ground nor a wall, all may be moved and turned together.
  const NodeId keyframe = graph.keyframes()[20]->id;
  std::vector<EdgeId> factors;
  for (const EdgeId id : graph.edgesOf(keyframe)) {
    const auto& edge = graph.edgeSlots()[id.value];
    if (dynamic_cast<const CEdgeOdometry*>(edge.get()) ||
        dynamic_cast<const CEdgeKeyframeEntity*>(edge.get()))
      factors.push_back(id);
  }
  const std::vector<NodeId> leaving = {keyframe};
  const life::LocalMarginal marginal(graph, leaving, factors);
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(marginal.information());
  const VectorX& values = eigen.eigenvalues();
  for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(values[i]), 1e-2) << i;
  EXPECT_GT(values[6], 1.0);
}

}  // namespace
}  // namespace dynemo
