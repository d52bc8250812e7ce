#include "dynemo/evaluation/loop_error.h"

#include <gtest/gtest.h>

#include "example_run.h"

namespace dynemo::test {
namespace {

/// Twice around a square of 4 m, one pose per metre and second.
Trajectory twoLaps() {
  Trajectory laps;
  for (int i = 0; i < 32; ++i) {
    const int side = i % 16 / 4, along = i % 4;
    const double x[] = {1.0 * along, 4.0, 4.0 - along, 0.0};
    const double y[] = {0.0, 1.0 * along, 4.0, 4.0 - along};
    laps.push_back({at(i), Pose3::translation(x[side], y[side], 0)});
  }
  return laps;
}

const LoopGate kGate{0.5, 8.0, 0.0};  // the same place a lap later, and nothing else

LoopEstimate loop(std::uint64_t edge, int earlier, int later, double error_m = 0.0) {
  const Trajectory truth = twoLaps();
  const auto index = [](int i) { return static_cast<std::size_t>(i); };
  return {
      {edge},
      at(earlier),
      at(later),
      truth[index(earlier)].T.inverse() * truth[index(later)].T * Pose3::translation(error_m, 0, 0),
      false};
}

LoopReport evaluate(const std::vector<LoopEstimate>& loops,
                    const std::optional<LoopGate>& gate = kGate) {
  return evaluateLoops(loops, twoLaps(), twoLaps(), gate);
}

TEST(LoopErrors, CountsRightAndWrongOnes) {
  const LoopReport report = evaluate({loop(1, 0, 16), loop(2, 1, 17, 0.19), loop(3, 2, 18, 0.21)});
  EXPECT_EQ(report.closures, 3u);
  EXPECT_EQ(report.right, 2u);
  EXPECT_NEAR(report.precision(), 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(report.errors.translation_m.max, 0.21, 1e-9);
}

TEST(LoopErrors, ATurnedOneIsWrong) {
  LoopEstimate turned = loop(1, 0, 16);
  turned.T_earlier_later = turned.T_earlier_later * Pose3::fromYawPitchRoll(0, 0, 0, 0.1, 0, 0);
  EXPECT_EQ(evaluate({turned}).right, 0u);
}

TEST(LoopErrors, RecallIsOverTheKeyframesOfTheSecondLap) {
  const LoopReport report = evaluate({loop(1, 0, 16), loop(2, 4, 20), loop(3, 5, 21, 1.0)});
  EXPECT_EQ(report.closable, 16u);
  EXPECT_EQ(report.recalled, 2u);  // the wrong one finds nothing
  EXPECT_NEAR(report.recall(), 0.125, 1e-12);
}

TEST(LoopErrors, ASpacingLeavesFewerToFind) {
  // Every fourth keyframe is due; one is served by a closure a metre later.
  const LoopReport report = evaluate({loop(1, 0, 16), loop(2, 5, 21)}, LoopGate{0.5, 8.0, 4.0});
  EXPECT_EQ(report.closable, 4u);
  EXPECT_EQ(report.recalled, 2u);
}

TEST(LoopErrors, WhatWasTakenOutCountsApart) {
  LoopEstimate right = loop(1, 0, 16), wrong = loop(2, 1, 17, 1.0);
  right.removed = wrong.removed = true;
  const LoopReport report = evaluate({right, wrong, loop(3, 2, 18)});
  EXPECT_EQ(report.closures, 1u);
  EXPECT_EQ(report.precision(), 1.0);
  EXPECT_EQ(report.removed, 2u);
  EXPECT_EQ(report.removed_right, 1u);
  EXPECT_EQ(report.recalled, 1u);
}

TEST(LoopErrors, WithoutClosuresOrGateThereIsNothingToBlame) {
  EXPECT_EQ(evaluate({}).precision(), 1.0);
  EXPECT_EQ(evaluate({}).recall(), 0.0);
  EXPECT_TRUE(std::isnan(evaluate({}, std::nullopt).recall()));
}

TEST(LoopErrors, OutsideOfTheReferenceNothingIsSaid) {
  LoopEstimate late = loop(1, 0, 16);
  late.later = at(100);
  EXPECT_EQ(evaluate({late}).without_truth, 1u);
  EXPECT_EQ(evaluate({late}).closures, 0u);
}

constexpr const char* kHeader =
    "timestamp,decision,edge_id,earlier_timestamp,later_timestamp,x,y,z,qx,qy,qz,qw\n";

TEST(LoopFile, ListsWhatWasAcceptedAndWhetherItStayed) {
  const Folder folder;
  const auto file = folder.write(
      "loops.csv", std::string(kHeader) + "5,accepted,7,1,5,1,2,3,0,0,0,1\n" +
                       "5,rejected,,2,5,,,,,,,\n" + "6,accepted,9,2,6,0,0,0,0,0,0,1\n" +
                       "8,removed,7,1,5,1,2,3,0,0,0,1\n");
  const auto loops = readLoopEstimates(file);
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(loops[0].edge.value, 7u);
  EXPECT_TRUE(loops[0].removed);
  EXPECT_EQ(loops[0].T_earlier_later.t, Vector3(1, 2, 3));
  EXPECT_FALSE(loops[1].removed);
}

TEST(LoopFile, NamesTheRowThatMakesNoSense) {
  const Folder folder;
  const auto file =
      folder.write("loops.csv", std::string(kHeader) + "8,removed,7,1,5,1,2,3,0,0,0,1\n");
  const std::string message = dataError([&] { readLoopEstimates(file); });
  EXPECT_NE(message.find("loops.csv:2"), std::string::npos) << message;
  EXPECT_NE(message.find("edge_id"), std::string::npos);
}

TEST(LoopGates, AreThoseOfTheRunsConfiguration) {
  const Folder folder;
  const std::string candidates =
      "  candidates: {max_distance_m: 1.5, min_path_m: 4, spacing_m: 2}\n";
  const auto gate = readLoopGate(folder.write("on.yaml", "loops:\n  enabled: true\n" + candidates));
  ASSERT_TRUE(gate);
  EXPECT_EQ(gate->max_distance_m, 1.5);
  EXPECT_EQ(gate->min_path_m, 4.0);
  EXPECT_EQ(gate->spacing_m, 2.0);
  EXPECT_FALSE(readLoopGate(folder.write("off.yaml", "loops:\n  enabled: false\n" + candidates)));
  EXPECT_FALSE(readLoopGate(folder.path() / "missing.yaml"));
  const auto damaged = folder.write("damaged.yaml", "loops: {enabled: true}\n");
  EXPECT_NE(dataError([&] { readLoopGate(damaged); }).find("damaged.yaml"), std::string::npos);
}

}  // namespace
}  // namespace dynemo::test
