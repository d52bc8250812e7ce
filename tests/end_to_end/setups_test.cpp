// Each setup of the paper makes the keyframes and constraints that it stands for.
#include <gtest/gtest.h>

#include "slam_run.h"

namespace dynemo::test {
namespace {

struct Setup {
  const char* name;
  bool entities, intra_entity, floor_entity, timer;
  const char* prefilter;
};

class Setups : public testing::TestWithParam<Setup> {};

/// Whether any keyframe was made for a reason that contains the text.
bool hasReason(const SlamRun& run, const std::string& reason) {
  const nlohmann::json summary = run.summary();
  for (const auto& [reasons, count] : summary.at("keyframes").at("reasons").items()) {
    if (reasons.find(reason) != std::string::npos) return true;
  }
  return false;
}

TEST_P(Setups, HaveTheirConstraintsAndNoOthers) {
  const SlamRun& run = bundledRun(GetParam().name);
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run.summary().at("setup"), GetParam().name);
  EXPECT_GT(run.nodes("keyframe"), 10u);
  EXPECT_EQ(run.edges("odometry"), run.nodes("keyframe") - 1);
  EXPECT_EQ(run.nodes("entity") > 0, GetParam().entities);
  EXPECT_EQ(run.edges("keyframe_entity"), run.nodes("entity"));
  EXPECT_EQ(run.edges("intra_entity") > 0, GetParam().intra_entity);
  EXPECT_EQ(run.edges("agent_line") > 0, GetParam().intra_entity);
  EXPECT_EQ(run.edges("floor_entity"), GetParam().floor_entity ? run.nodes("entity") : 0u);
}

TEST_P(Setups, MakeKeyframesForTheirReasons) {
  const SlamRun& run = bundledRun(GetParam().name);
  ASSERT_TRUE(run.ok());
  EXPECT_TRUE(hasReason(run, "robot_moved"));
  EXPECT_EQ(hasReason(run, "new_entity"), GetParam().entities);
  EXPECT_EQ(hasReason(run, "entity_moved"), GetParam().entities);
  EXPECT_TRUE(GetParam().timer || !hasReason(run, "timer_expired"));
}

TEST(Setup, FullRegistersRestingObjectsAgainByTimer) {
  // The robot seldom stays within half a metre for the default time.
  const SlamRun run(bundledSample(), {"--setup", "full", "--set", "keyframes.timer_s=1"});
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  EXPECT_TRUE(hasReason(run, "timer_expired"));
}

TEST_P(Setups, CloseLoopsWithTheirPrefilterAndOnlyRightOnes) {
  const SlamRun& run = bundledRun(GetParam().name);
  ASSERT_TRUE(run.ok());
  EXPECT_GT(run.edges("loop_closure"), 0u);
  EXPECT_EQ(run.summary().at("loops").at("closures"), run.edges("loop_closure"));
  const nlohmann::json loops = run.evaluate().at("loops");
  EXPECT_EQ(loops.at("precision"), 1.0);
  EXPECT_GE(loops.at("recall").get<double>(), 0.8);
  const std::string rows = readBytes(run.folder() / "loops.csv");
  EXPECT_EQ(rows.find(": always: ") != std::string::npos,
            GetParam().prefilter == std::string("always"));
  EXPECT_EQ(rows.find(": moved ") != std::string::npos,
            GetParam().prefilter == std::string("motion"));
}

INSTANTIATE_TEST_SUITE_P(OfThePaper, Setups,
                         testing::Values(Setup{"baseline", false, false, false, false, "none"},
                                         Setup{"only-kf-e", true, false, false, false, "none"},
                                         Setup{"intra-e", true, true, false, false, "none"},
                                         Setup{"f-e", true, false, true, false, "none"},
                                         Setup{"fcs", true, true, true, false, "none"},
                                         Setup{"always-epcr", true, true, true, false, "always"},
                                         Setup{"mb-epcr", true, true, true, false, "motion"},
                                         Setup{"full", true, true, true, true, "motion"}));

TEST(SetupFiles, AreTheEightOfThePaper) {
  std::set<std::string> names;
  for (const auto& entry :
       fs::directory_iterator(fs::path(DYNEMO_SOURCE_DIR) / "config" / "setups"))
    names.insert(entry.path().stem());
  EXPECT_EQ(names, (std::set<std::string>{"always-epcr", "baseline", "f-e", "fcs", "full",
                                          "intra-e", "mb-epcr", "only-kf-e"}));
}

}  // namespace
}  // namespace dynemo::test
