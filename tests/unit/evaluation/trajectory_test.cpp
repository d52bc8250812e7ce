#include "dynemo/evaluation/trajectory.h"

#include <gtest/gtest.h>

#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-12;

TEST(Tum, SkipsCommentsAndBlankLinesAndTakesAnySpacing) {
  const Trajectory t = parseTum(
      "# a comment\n\n  \t\n 1700000000.5\t1  2 3 0 0 0 1 \r\n1700000001 4 5 6 0 0 2 0\n  # end\n",
      "x.tum");
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].stamp.ns, 1'700'000'000'500'000'000);
  EXPECT_EQ(t[0].T.t, Vector3(1, 2, 3));
  EXPECT_NEAR(t[1].T.R(0, 0), -1.0, kTolerance);
}

TEST(Tum, KeepsNanosecondsOfLargeStamps) {
  EXPECT_EQ(parseTum("1700000030.123456789 0 0 0 0 0 0 1", "x")[0].stamp.ns,
            1'700'000'030'123'456'789);
}

TEST(Tum, SortsByStamp) {
  const Trajectory t = parseTum("2 2 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n", "x");
  EXPECT_EQ(t[0].T.t.x(), 1.0);
}

TEST(Tum, NamesFileAndLineOfWhatIsWrong) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  for (const char* bad :
       {"2 0 0 0 0 0 1", "2 0 0 0 0 0 0 1 7", "2 x 0 0 0 0 0 1", "2 nan 0 0 0 0 0 1",
        "2 0 0 0 0 0 0 0", "soon 0 0 0 0 0 0 1", "2 0 inf 0 0 0 0 1", "2,0,0,0,0,0,0,1"}) {
    const std::string message =
        dataError([&] { parseTum("# c\n" + good + bad + "\n", "run/x.tum"); });
    EXPECT_NE(message.find("run/x.tum:3: "), std::string::npos) << bad << " → " << message;
  }
}

TEST(Tum, RefusesEmptyAndMissingFilesByName) {
  EXPECT_NE(dataError([] { parseTum("# nothing\n", "e.tum"); }).find("e.tum"), std::string::npos);
  EXPECT_NE(dataError([] { readTum("/nonexistent/m.tum"); }).find("/nonexistent/m.tum"),
            std::string::npos);
  EXPECT_NE(dataError([] { readTum("/tmp"); }).find("folder"), std::string::npos);
}

TEST(Tum, WhatIsWrittenReadsBack) {
  constexpr double kTextTolerance = 2e-9;
  const Folder folder;
  const Trajectory before = curve(20);
  writeTum(before, folder.path() / "t.tum");
  const Trajectory after = readTum(folder.path() / "t.tum");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].stamp, before[i].stamp);
    EXPECT_LT(local(before[i].T, after[i].T).norm(), kTextTolerance);
  }
}

TEST(PoseAt, InterpolatesInsideAndIsEmptyOutside) {
  const Trajectory t = {{at(1), Pose3()}, {at(3), Pose3::fromYawPitchRoll(4, 0, 0, 1.0, 0, 0)}};
  EXPECT_FALSE(poseAt(t, at(0.9)));
  EXPECT_FALSE(poseAt(t, at(3.1)));
  EXPECT_LT(local(*poseAt(t, at(1)), t[0].T).norm(), kTolerance);
  EXPECT_LT(local(*poseAt(t, at(3)), t[1].T).norm(), kTolerance);
  EXPECT_LT(local(*poseAt(t, at(1.5)), Pose3::fromYawPitchRoll(1, 0, 0, 0.25, 0, 0)).norm(),
            kTolerance);
}

}  // namespace
}  // namespace dynemo::test
