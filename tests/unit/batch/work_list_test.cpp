#include <gtest/gtest.h>

#include "dynemo/batch/work_list.h"
#include "dynemo/core/error.h"
#include "generated_rawlog.h"

namespace dynemo::test {
namespace {

class WorkList : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"a/log.rawlog", "b/log.rawlog", "b/other.rawlog", "b/notes.txt"}) {
      fs::create_directories((folder / name).parent_path());
      writeFile(folder / name, "x");
    }
    writeFile(folder / "b/other_entities.yaml", "x");
    writeFile(folder / "b/other_gt_robot.tum", "x");
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }
  TemporaryFolder folder;
};

TEST_F(WorkList, WordsAreFilesPatternsAndLists) {
  EXPECT_EQ(expandRawlogs({path("b/other.rawlog")}), std::vector<fs::path>{path("b/other.rawlog")});
  EXPECT_EQ(
      expandRawlogs({path("*/*.rawlog")}),
      (std::vector<fs::path>{path("a/log.rawlog"), path("b/log.rawlog"), path("b/other.rawlog")}));
  writeFile(folder / "list.txt", "# all of b\n  b/*.rawlog \n\n" + path("a/log.rawlog") + "\r\n");
  EXPECT_EQ(
      expandRawlogs({"@" + path("list.txt"), path("a/log.rawlog")}),
      (std::vector<fs::path>{path("b/log.rawlog"), path("b/other.rawlog"), path("a/log.rawlog")}));
}

TEST_F(WorkList, WhatNamesNothingIsAnError) {
  EXPECT_THROW(expandRawlogs({path("nope.rawlog")}), DataError);
  EXPECT_THROW(expandRawlogs({path("*.nope")}), DataError);
  EXPECT_THROW(expandRawlogs({"@" + path("nope.txt")}), DataError);
  writeFile(folder / "empty.txt", "# nothing\n");
  EXPECT_THROW(expandRawlogs({"@" + path("empty.txt")}), DataError);
}

TEST_F(WorkList, IsTheProductOfRawlogsAndSetups) {
  WorkPlan plan;
  plan.setups = {"baseline", path("mine.yaml")};
  plan.overrides = {"a.b=1"};
  const auto items = makeWorkList({path("a/log.rawlog"), path("b/other.rawlog")}, plan);
  ASSERT_EQ(items.size(), 4U);
  EXPECT_EQ(items[0].name, "log/baseline");
  EXPECT_EQ(items[3].name, "other/mine");
  EXPECT_EQ(items[0].arguments, (std::vector<std::string>{"--setup", "baseline", "--set", "a.b=1",
                                                          path("a/log.rawlog")}));
  EXPECT_EQ(items[3].arguments,
            (std::vector<std::string>{"--config", path("mine.yaml"), "--set", "a.b=1", "--entities",
                                      path("b/other_entities.yaml"), path("b/other.rawlog")}));
  EXPECT_EQ(items[0].trajectory_truth, "");
  EXPECT_EQ(items[3].trajectory_truth, path("b/other_gt_robot.tum"));
}

TEST_F(WorkList, RawlogsOfTheSameNameAreToldByTheirFolders) {
  const auto items = makeWorkList({path("a/log.rawlog"), path("b/log.rawlog")}, {});
  EXPECT_EQ(items[0].name, "a-log/default");
  EXPECT_EQ(items[1].name, "b-log/default");
}

TEST_F(WorkList, RunsThatWouldShareAFolderAreRefused) {
  WorkPlan plan;
  plan.setups = {"full", "full"};
  EXPECT_THROW(makeWorkList({path("a/log.rawlog")}, plan), ConfigError);
  plan.setups = {path("x.yaml")};
  plan.config = path("y.yaml");
  EXPECT_THROW(makeWorkList({path("a/log.rawlog")}, plan), ConfigError);
}

TEST_F(WorkList, SurvivesItsFile) {
  const auto items = makeWorkList({path("a/log.rawlog"), path("b/other.rawlog")}, {});
  writeFile(folder / "work.json", workListJson(items));
  const auto read = readWorkList(folder / "work.json");
  EXPECT_EQ(workListJson(read), workListJson(items));
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].arguments, items[1].arguments);
  writeFile(folder / "work.json", "[{\"name\": 3}]");
  EXPECT_THROW(readWorkList(folder / "work.json"), DataError);
  EXPECT_THROW(readWorkList(folder / "missing.json"), DataError);
}

}  // namespace
}  // namespace dynemo::test
