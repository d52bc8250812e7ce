#include "dynemo/experiments/claims.h"

#include <gtest/gtest.h>

#include "made_up_runs.h"

namespace dynemo::experiments {
namespace {

using test::madeUp;

PaperTables paper() {
  return PaperTables::read(std::string(DYNEMO_SOURCE_DIR) + "/share/data/paper");
}

Verdict verdictOf(const std::vector<RunResult>& results, const std::string& text) {
  for (const Claim& claim : judgeClaims(results, paper()))
    if (claim.text.find(text) != std::string::npos) return claim.verdict;
  ADD_FAILURE() << text << " is not judged";
  return Verdict::kNotRun;
}

std::vector<RunResult> threeSeeds(const std::vector<double>& full_m) {
  std::vector<RunResult> results;
  for (int seed = 1; seed <= 3; ++seed) {
    results.push_back(madeUp("S-SAMO", seed, "baseline", 0.10));
    results.push_back(madeUp("S-SAMO", seed, "full", full_m[static_cast<std::size_t>(seed - 1)]));
  }
  return results;
}

TEST(Claims, FollowTheInterval) {
  const std::string claim = "full system cuts";
  EXPECT_EQ(verdictOf(threeSeeds({0.03, 0.04, 0.035}), claim), Verdict::kBorneOut);
  EXPECT_EQ(verdictOf(threeSeeds({0.13, 0.14, 0.135}), claim), Verdict::kNotBorneOut);
  EXPECT_EQ(verdictOf(threeSeeds({0.03, 0.14, 0.10}), claim), Verdict::kUndecided);
}

TEST(Claims, WithoutItsRunsAClaimIsNotJudged) {
  EXPECT_EQ(verdictOf(threeSeeds({0.03, 0.04, 0.035}), "timer helps short"), Verdict::kNotRun);
}

TEST(Claims, StaticScenesOnlyCountWhereNothingMoves) {
  std::vector<RunResult> results;
  for (int seed = 1; seed <= 2; ++seed) {
    results.push_back(madeUp("S-MAMO", seed, "mb-epcr", 0.2));
    results.push_back(madeUp("S-MAMO", seed, "always-epcr", 0.1));
    results.push_back(madeUp("S-SASO", seed, "mb-epcr", 0.1));
    results.push_back(madeUp("S-SASO", seed, "always-epcr", 0.2));
  }
  EXPECT_EQ(verdictOf(results, "hurts in static"), Verdict::kBorneOut);
}

TEST(Claims, CompareTheSameSeedOnly) {
  EXPECT_EQ(verdictOf({madeUp("S-SAMO", 1, "baseline", 0.1), madeUp("S-SAMO", 2, "full", 0.01)},
                      "full system cuts"),
            Verdict::kNotRun);
}

}  // namespace
}  // namespace dynemo::experiments
