#include "dynemo/pipeline/doubts.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

const RunFacts kGood = {.frames = 100,
                        .guessed_frames = 3,
                        .keyframes = 20,
                        .entities_described = true,
                        .entities = 4,
                        .unknown_detections = 2};

/// The only doubt about a run; fails when there is none or more than one.
std::string doubtAbout(const RunFacts& run) {
  const auto doubts = doubtsAbout(run);
  EXPECT_EQ(doubts.size(), 1u);
  return doubts.empty() ? "" : doubts.front();
}

TEST(Doubts, AGoodRunHasNone) {
  EXPECT_TRUE(doubtsAbout(kGood).empty());
  EXPECT_TRUE(doubtsAbout({}).empty());
  EXPECT_TRUE(doubtsAbout({.frames = 100, .keyframes = 20}).empty()) << "a map without entities";
}

TEST(Doubts, ARobotThatIsLostGivesNoMap) {
  RunFacts run = kGood;
  run.guessed_frames = 11;
  EXPECT_NE(doubtAbout(run).find("11 of 100 frames"), std::string::npos);
  run.frames = 5;
  run.guessed_frames = 4;
  run.keyframes = 1;
  EXPECT_NE(doubtAbout(run).find("4 of 5 frames"), std::string::npos);
}

TEST(Doubts, OneViewIsHardlyAMap) {
  RunFacts run = kGood;
  run.keyframes = 1;
  EXPECT_NE(doubtAbout(run).find("one place"), std::string::npos);
  run.frames = 1;
  run.guessed_frames = 0;
  EXPECT_TRUE(doubtsAbout(run).empty()) << "what else of one frame?";
}

TEST(Doubts, DetectionsNeedTheEntityFileOfTheirRecording) {
  RunFacts run = kGood;
  run.entities = 0;
  run.unknown_detections = 260;
  EXPECT_NE(doubtAbout(run).find("none of the 260"), std::string::npos);
  run.entities_described = false;
  EXPECT_NE(doubtAbout(run).find("--entities"), std::string::npos);
  run.entities_mapped = false;
  EXPECT_TRUE(doubtsAbout(run).empty()) << "a configuration that maps no entities";
  run = kGood;
  run.entities = run.unknown_detections = 0;
  EXPECT_NE(doubtAbout(run).find("no entity of the entity file"), std::string::npos);
}

}  // namespace
}  // namespace dynemo
