#include "dynemo/loops/loop_closer.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <sstream>

#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/life/removal.h"
#include "dynemo/loops/without_closures.h"
#include "loop_graph.h"

namespace dynemo {
namespace {

constexpr int kLap = 24;

/// Stands in for scan matching: knows the truth, and lies where it is told to.
class TruthMatcher : public ScanMatcher {
 public:
  /// The error of a match; nothing where it finds none.
  using Lie = std::function<std::optional<Pose3>(std::size_t earlier, std::size_t later)>;
  TruthMatcher(const test::LoopGraph& drive, Lie lie) : drive_(drive), lie_(std::move(lie)) {}

  Expected<ScanMatch, MatchFailure> match(const MatchScan&, const MatchScan&,
                                          const MatchRequest& request) const override {
    const std::size_t later = drive_.graph.keyframes().size() - 1, earlier = earlierOf(request);
    const auto error = lie_(earlier, later);
    if (!error) return make_unexpected(MatchFailure::kNoOverlap);
    ScanMatch match;
    match.T_target_source = drive_.trueRelative(earlier, later) * *error;
    match.covariance = isotropicCovariance(0.002, 0.0005);
    match.overlap = match.inlier_ratio = 0.95;
    match.residual_rms_m = 0.01;
    match.min_eigenvalue = 0.1;
    return match;
  }

 private:
  /// The keyframe that the guess is relative to.
  std::size_t earlierOf(const MatchRequest& request) const {
    const auto& keyframes = drive_.graph.keyframes();
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
      const Pose3 T = keyframes[k]->T_map_base().inverse() * keyframes.back()->T_map_base();
      if (local(T, request.T_target_source_guess).norm() < 1e-12) return k;
    }
    throw std::logic_error("the guess is not the graph's");
  }
  const test::LoopGraph& drive_;
  Lie lie_;
};

TruthMatcher::Lie honest() {
  return [](std::size_t, std::size_t) { return Pose3(); };
}

struct Outcome {
  double rmse_m = 0.0;
  std::size_t closures = 0;
  std::vector<LoopRecord> records;
  std::size_t count(LoopDecision decision) const {
    return static_cast<std::size_t>(std::count_if(
        records.begin(), records.end(), [&](const auto& r) { return r.decision == decision; }));
  }
};

/// A closure at every keyframe that has one: there is something to vote.
LoopParams withoutSpacing() {
  LoopParams params;
  params.candidates.spacing_m = 0.0;
  return params;
}

Outcome run(test::LoopGraph& drive, int keyframes, const TruthMatcher::Lie& lie,
            const LoopParams& params = withoutSpacing()) {
  LoopCloser closer(params, std::make_unique<TruthMatcher>(drive, lie));
  for (int i = 0; i < keyframes; ++i) {
    drive.addKeyframe();
    drive.graph.apply(closer.close(drive.graph, drive.optimizer));
    drive.optimize();
  }
  for (GraphDelta delta = closer.review(drive.graph); !delta.empty();
       delta = closer.review(drive.graph)) {
    drive.graph.apply(delta);
    drive.optimize();
  }
  return {drive.rmse_m(), closer.closures(), closer.records()};
}

std::size_t closureEdges(const CSceneGraph& graph) {
  return static_cast<std::size_t>(std::count_if(
      graph.edgeSlots().begin(), graph.edgeSlots().end(),
      [](const auto& e) { return dynamic_cast<const CEdgeLoopClosure*>(e.get()) != nullptr; }));
}

test::LoopGraphParams driftingBy(double factor) {
  test::LoopGraphParams params;
  params.sigma_m *= factor;
  params.sigma_rad *= factor;
  return params;
}

TEST(LoopCloser, ClosuresTakeTheDriftOut) {
  test::LoopGraph with, without;
  LoopParams off = withoutSpacing();
  off.enabled = false;
  const Outcome closed = run(with, 2 * kLap, honest());
  const Outcome open = run(without, 2 * kLap, honest(), off);
  EXPECT_GT(closed.closures, 15u);
  EXPECT_EQ(closureEdges(with.graph), closed.closures);
  EXPECT_EQ(open.closures, 0u);
  EXPECT_LT(closed.rmse_m, 0.6 * open.rmse_m);
}

TEST(LoopCloser, AtMostOneClosurePerKeyframeTheBest) {
  test::LoopGraph drive;
  const Outcome outcome = run(drive, 3 * kLap, honest());
  std::set<NodeId> later;
  for (const LoopRecord& record : outcome.records) {
    if (record.decision != LoopDecision::kAccepted) continue;
    EXPECT_TRUE(later.insert(record.later).second);
  }
  EXPECT_GT(outcome.count(LoopDecision::kRejected), 0u);
}

TEST(LoopCloser, AClosureFarFromTheGraphIsRefused) {
  test::LoopGraph drive;
  const Outcome outcome = run(drive, 2 * kLap, [](std::size_t, std::size_t later) {
    return later == kLap + 5 ? Pose3::translation(3, 0, 0) : Pose3();
  });
  std::size_t refused = 0;
  for (const LoopRecord& record : outcome.records) {
    if (record.later != drive.graph.keyframes()[kLap + 5]->id) continue;
    EXPECT_EQ(record.decision, LoopDecision::kRejected);
    EXPECT_EQ(record.reason, "contradicts the graph");
    ++refused;
  }
  EXPECT_GE(refused, 1u);
}

TEST(LoopCloser, AWrongFirstClosureIsTakenOutByLaterOnes) {
  test::LoopGraph drive;
  std::optional<std::size_t> first;
  const Outcome outcome = run(drive, 2 * kLap, [&](std::size_t, std::size_t later) {
    if (!first) first = later;
    // Within what the odometry leaves open.
    return later == *first ? Pose3::translation(0.25, 0.2, 0) : Pose3();
  });
  EXPECT_EQ(outcome.count(LoopDecision::kRemoved), 1u);
  const NodeId wrong = drive.graph.keyframes()[*first]->id;
  for (const auto& slot : drive.graph.edgeSlots()) {
    const auto* edge = dynamic_cast<const CEdgeLoopClosure*>(slot.get());
    EXPECT_FALSE(edge && edge->nodes[1] == wrong);
  }
  EXPECT_GT(outcome.closures, 15u);
}

/// Five of some twenty closures wrong: how, the factor of the odometry's error, the seed.
class WrongClosures : public testing::TestWithParam<std::tuple<const char*, double, unsigned>> {};

TEST_P(WrongClosures, CostNoAccuracy) {
  const auto [kind, drift, seed] = GetParam();
  test::LoopGraphParams params = driftingBy(drift);
  params.seed = seed;
  params.claimed_scale = 1.0 / drift;  // the graph believes in the smaller error
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Pose3> errors;
  for (int i = 0; i < 5; ++i) {
    // A closure off by more than 0.2 m counts as wrong.
    const double angle = M_PI * uniform(rng);
    const double off_m = (kind == std::string("far") ? 2.0 : 0.4) + 0.1 * uniform(rng);
    const Pose3 random = Pose3::fromYawPitchRoll(off_m * std::cos(angle), off_m * std::sin(angle),
                                                 0, 0.1 * uniform(rng), 0, 0);
    errors.push_back(kind == std::string("alike") && i > 0 ? errors.front() : random);
  }
  // Every fourth keyframe of the second lap, or five in a row.
  const auto wrong = [&](std::size_t later) -> std::optional<Pose3> {
    const bool in_a_row = kind == std::string("alike");
    for (std::size_t i = 0; i < 5; ++i) {
      if (later == kLap + 3 + (in_a_row ? 8 + i : 4 * i)) return errors[i];
    }
    return std::nullopt;
  };
  test::LoopGraph misled(params), spared(params);
  const Outcome with_wrong = run(misled, 2 * kLap, [&](std::size_t, std::size_t later) {
    return wrong(later).value_or(Pose3());
  });
  const Outcome without = run(spared, 2 * kLap, [&](std::size_t, std::size_t later) {
    return wrong(later) ? std::nullopt : std::optional(Pose3());
  });
  EXPECT_GE(without.closures, 15u);
  EXPECT_LE(with_wrong.rmse_m, 1.1 * without.rmse_m);
}

INSTANTIATE_TEST_SUITE_P(FiveOfTwenty, WrongClosures,
                         testing::Combine(testing::Values("far", "near"), testing::Values(1.0, 2.0),
                                          testing::Values(1u, 2u, 3u, 4u)));
// Five neighbours with the same error: with odometry twice as bad as it says nothing could tell
// them from drift.
INSTANTIATE_TEST_SUITE_P(FiveInARow, WrongClosures,
                         testing::Combine(testing::Values("alike"), testing::Values(1.0),
                                          testing::Values(1u, 2u, 3u, 4u)));

TEST(LoopCloser, FurtherClosuresOfAPlaceWeighLess) {
  test::LoopGraph drive;
  run(drive, 2 * kLap, honest());
  std::vector<double> sigma;
  for (const auto& slot : drive.graph.edgeSlots()) {
    const auto* edge = dynamic_cast<const CEdgeLoopClosure*>(slot.get());
    if (edge) sigma.push_back(1.0 / std::sqrt(edge->information()(0, 0)));
  }
  ASSERT_GE(sigma.size(), 3u);
  EXPECT_GT(sigma[1], 1.3 * sigma[0]);
  EXPECT_GT(sigma[2], 1.6 * sigma[0]);
}

TEST(LoopCloser, EveryRecordIsOneRowOfTheHeadersLength) {
  test::LoopGraph drive;
  const Outcome outcome = run(drive, 2 * kLap, honest());
  const auto commas = [](const std::string& s) { return std::count(s.begin(), s.end(), ','); };
  for (const LoopRecord& record : outcome.records) {
    const std::string row = loopRecordRow(record);
    EXPECT_EQ(commas(row), commas(loopRecordHeader())) << row;
    EXPECT_EQ(row.find('\n'), std::string::npos);
    EXPECT_EQ(record.decision == LoopDecision::kRejected, !record.edge.has_value());
  }
}

TEST(LoopCloser, WithoutClosuresTheGraphIsItsOdometry) {
  test::LoopGraph drive;
  run(drive, 2 * kLap, honest());
  // A node that was taken out, as merging does, leaves an empty slot.
  GraphDelta in, out;
  in.nodes = {std::make_shared<CNodePlane>()};
  in.nodes[0]->id = drive.graph.nextNodeId();
  out.removed_nodes = {in.nodes[0]->id};
  drive.graph.apply(in);
  drive.graph.apply(out);
  const auto poses = keyframesWithoutClosures(drive.graph, SolverParams{});
  ASSERT_EQ(poses.size(), drive.graph.keyframes().size());
  for (std::size_t k = 0; k < poses.size(); ++k)
    EXPECT_LT(local(drive.graph.keyframes()[k]->T_odom_base, poses[k]).norm(), 1e-4);
}

TEST(LoopCloser, ForgetsKeyframesThatLeave) {
  test::LoopGraph drive;
  bool blind = false;
  const LoopParams params;
  LoopCloser closer(params, std::make_unique<TruthMatcher>(drive, [&](std::size_t, std::size_t) {
                      return blind ? std::nullopt : std::optional(Pose3());
                    }));
  for (int i = 0; i < 2 * kLap; ++i) {
    drive.addKeyframe();
    drive.graph.apply(closer.close(drive.graph, drive.optimizer));
    drive.optimize();
  }
  const std::size_t closures = closer.closures();
  ASSERT_GT(closures, 5u);
  const NodeId anchor = drive.graph.keyframes().front()->id;
  const auto closure = std::find_if(
      drive.graph.edgeSlots().begin(), drive.graph.edgeSlots().end(), [&](const auto& edge) {
        return dynamic_cast<const CEdgeLoopClosure*>(edge.get()) && edge->nodes[0] != anchor;
      });
  ASSERT_NE(closure, drive.graph.edgeSlots().end());
  const NodeId leaving = (*closure)->nodes[0];
  std::size_t its_own = 0;
  for (const EdgeId id : drive.graph.edgesOf(leaving)) {
    const auto& edge = drive.graph.edgeSlots()[id.value];
    its_own += dynamic_cast<const CEdgeLoopClosure*>(edge.get()) ? 1 : 0;
  }
  const GraphDelta removal = removalOf(drive.graph, leaving, {});
  closer.forget(drive.graph, leaving);
  drive.graph.apply(removal);
  drive.optimize();
  EXPECT_EQ(closer.closures(), closures - its_own);
  EXPECT_TRUE(closer.review(drive.graph).empty());
  // And goes on; indices of keyframes are no longer the truth's, so it sees nothing.
  blind = true;
  drive.addKeyframe();
  EXPECT_TRUE(closer.close(drive.graph, drive.optimizer).empty());
  EXPECT_EQ(closer.closures(), closures - its_own);
  EXPECT_THROW(closer.forget(drive.graph, leaving), std::out_of_range);
}

}  // namespace
}  // namespace dynemo
