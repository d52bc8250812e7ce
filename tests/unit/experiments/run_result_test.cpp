#include "dynemo/experiments/run_result.h"

#include <gtest/gtest.h>

#include <fstream>

#include "dynemo/core/error.h"
#include "made_up_runs.h"

namespace dynemo::experiments {
namespace {

TEST(RunResult, ReadsBackWhatItWrites) {
  RunResult result = test::madeUp("S-SAMO", 3, "full", 0.0123456789012345);
  result.loop_closures = 4;
  const auto file = std::filesystem::path(testing::TempDir()) / "result.json";
  writeResult(result, file);
  const RunResult again = readResult(file);
  EXPECT_EQ(again.key, result.key);
  EXPECT_EQ(again.ate_rmse_m, result.ate_rmse_m);
  EXPECT_EQ(again.loop_closures, 4);
  ASSERT_EQ(again.entities.size(), 3u);
  EXPECT_EQ(again.entities[2].semantic_class, "agent");
  ASSERT_EQ(again.entity_samples.size(), 2u);
  EXPECT_EQ(again.entity_samples[1].rotation_deg, 1.0);
  EXPECT_EQ(again.entity_samples[1].place, result.entity_samples[1].place);
  EXPECT_EQ(again.optimization_cpu_ms, 2.5);
  EXPECT_EQ(again.optimization_samples[1].ms, 4.0);
  EXPECT_EQ(again.path, result.path);
}

TEST(RunResult, DamagedFileIsADataError) {
  const auto file = std::filesystem::path(testing::TempDir()) / "damaged.json";
  std::ofstream(file) << "{\"dataset\": \"S-SAMO\"}";
  EXPECT_THROW(readResult(file), DataError);
}

TEST(RunKey, IsAPathOfItsOwn) {
  EXPECT_EQ((RunKey{"S-SAMO", 2, "local_map", "full"}.path()), "S-SAMO/seed2/local_map/full");
}

TEST(ExperimentPlan, RunsAreAllCombinations) {
  ExperimentPlan plan;
  plan.datasets = {"A", "B"};
  plan.setups = {"x", "y", "z"};
  plan.odometries = {"o"};
  plan.seeds = 2;
  const auto runs = runsOf(plan);
  EXPECT_EQ(runs.size(), 12u);
  EXPECT_EQ(runs.back().path(), "B/seed2/o/z");
  plan.setups.clear();
  EXPECT_THROW(runsOf(plan), ConfigError);
}

}  // namespace
}  // namespace dynemo::experiments
