// The prefilters on pairs of keyframes of the sample recordings: pairs between which objects were
// moved, and pairs between which none was.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "dynemo/loops/candidate_search.h"
#include "dynemo/loops/entity_prefilter.h"
#include "dynemo/matching/matcher_chain.h"
#include "sample_dataset.h"
#include "sample_runs.h"

namespace dynemo {
namespace {

constexpr double kMaxDistance_m = 2.5, kMinPath_m = 5.0;
constexpr double kNoKernel_m = 1e3;
constexpr std::size_t kEnoughPairs = 10, kMostPairs = 30;
/// Medians over some dozens of pairs with the same points differ by no more.
constexpr double kSame_m = 1e-4;

using Errors = std::map<std::string, std::vector<double>>;  // by prefilter

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// At most kMostPairs, evenly spread.
std::vector<LoopPair> thinned(std::vector<LoopPair> all) {
  if (all.size() <= kMostPairs) return all;
  std::vector<LoopPair> some;
  for (std::size_t i = 0; i < kMostPairs; ++i) some.push_back(all[i * all.size() / kMostPairs]);
  return some;
}

class SamplePrefilters : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto folder = test::samplesFolder();
    if (!folder) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
    DynemoParams params;
    params.loops.enabled = false;
    run_ = test::runSample(*folder, GetParam(), params);
    collectPairs();
    moved_ = thinned(std::move(moved_));
    static_ = thinned(std::move(static_));
  }

  void collectPairs() {
    const CSceneGraph& graph = run_.pipeline->graph();
    OdometryChain chain;
    chain.extend(graph);
    Optimizer optimizer(SolverParams{});
    const auto& keyframes = graph.keyframes();
    for (std::size_t later = 0; later < keyframes.size(); ++later) {
      std::vector<const CNodeKeyframe*> others;
      std::vector<LoopCandidate> candidates;
      for (std::size_t k = 0; k < later; ++k) {
        const double distance_m =
            (keyframes[k]->T_map_base().t - keyframes[later]->T_map_base().t).head<2>().norm();
        if (distance_m > kMaxDistance_m || chain.pathBetween_m(k, later) < kMinPath_m) continue;
        others.push_back(keyframes[k].get());
        candidates.push_back({k, later, LoopOrigin::kDistance, distance_m, 0.0});
      }
      if (others.empty()) continue;
      const auto predicted = relativeEstimates(graph, optimizer, *keyframes[later], others).value();
      for (std::size_t i = 0; i < others.size(); ++i) {
        LoopPair pair{candidates[i], others[i], keyframes[later].get(), predicted[i], {}, {}};
        pair.shared = sharedEntities(graph, *pair.earlier, *pair.later);
        const FilteredPair filtered = motion_->filter(graph, pair, pair.predicted);
        const bool moved = std::any_of(
            filtered.entities.begin(), filtered.entities.end(),
            [](const EntityDecision& e) { return e.removed && e.reason.starts_with("moved"); });
        (moved ? moved_ : static_).push_back(std::move(pair));
      }
    }
  }

  Errors errors(const std::vector<LoopPair>& pairs, bool kernel) {
    MatchingParams matching;
    if (!kernel) {
      for (RegistrationParams* p : {&matching.annealed_gicp.coarse, &matching.annealed_gicp.fine})
        p->kernel_m = kNoKernel_m;
    }
    const auto matcher = makeScanMatcher(matching);
    Errors errors;
    for (const LoopPair& pair : pairs) {
      const Pose3 truth = poseAt(run_.truth, pair.earlier->stamp)->inverse() *
                          *poseAt(run_.truth, pair.later->stamp);
      const MatchScan target(*pair.earlier->scan, matching.scan),
          source(*pair.later->scan, matching.scan);
      MatchRequest request;
      request.T_target_source_guess = pair.predicted.T;
      for (const std::string& method : entityPrefilters().names()) {
        const auto filtered = entityPrefilters()
                                  .make(method, PrefilterParams{})
                                  ->filter(run_.pipeline->graph(), pair, pair.predicted);
        const auto match =
            matcher->match(target.without(*pair.earlier->scan, filtered.removed_earlier),
                           source.without(*pair.later->scan, filtered.removed_later), request);
        errors[method].push_back(match ? (match->T_target_source.t - truth.t).norm() : 1.0);
      }
    }
    std::cout << GetParam() << ", " << pairs.size() << " pairs"
              << (kernel ? ", robust kernel:" : ", no kernel:");
    for (const auto& [method, list] : errors)
      std::cout << "  " << method << " " << 100 * median(list) << " cm";
    std::cout << '\n';
    return errors;
  }

  test::SampleRun run_;
  std::unique_ptr<EntityPrefilter> motion_ = entityPrefilters().make("motion", PrefilterParams{});
  std::vector<LoopPair> moved_, static_;
};

TEST_P(SamplePrefilters, WhereNothingMovedNothingIsLost) {
  ASSERT_GE(static_.size(), kEnoughPairs);
  for (const bool kernel : {false, true}) {
    auto e = errors(static_, kernel);
    EXPECT_LE(median(e["motion"]), median(e["none"]) + kSame_m);
  }
}

TEST_P(SamplePrefilters, WhatMovedIsBetterLeftOut) {
  if (moved_.size() < kEnoughPairs) GTEST_SKIP() << "only " << moved_.size() << " pairs";
  for (const bool kernel : {false, true}) {
    auto e = errors(moved_, kernel);
    EXPECT_LE(median(e["motion"]), median(e["none"]) + kSame_m);
  }
}

INSTANTIATE_TEST_SUITE_P(Simulated, SamplePrefilters, testing::Values("mini_samo", "mini_mamo"));

}  // namespace
}  // namespace dynemo
