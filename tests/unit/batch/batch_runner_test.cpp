// The runner with a script in place of dynemo-slam, so that runs take as long as a test wants.
#include "dynemo/batch/batch_runner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>

#include "dynemo/batch/configuration_check.h"
#include "dynemo/batch/summary.h"
#include "dynemo/core/error.h"
#include "generated_rawlog.h"

namespace dynemo::test {
namespace {

class Runner : public ::testing::Test {
 protected:
  void SetUp() override {
    // Called as: --output DIR WORD; leaves a file, counts its calls, and fails for the word "bad".
    script("mkdir -p \"$2\"\necho call >> '" + (folder / "calls").string() +
           "'\necho \" 40 %  working\"\n"
           "if [ \"$3\" = bad ]; then echo the reason >&2; exit 3; fi\n"
           "if [ \"$3\" = killed ]; then kill -9 $$; fi\n"
           "echo \"$3\" > \"$2/result.txt\"\n");
    params.program = folder / "program.sh";
  }
  void script(const std::string& body) {
    writeFile(folder / "program.sh", "#!/bin/sh\n" + body);
    fs::permissions(folder / "program.sh", fs::perms::owner_all);
  }
  static WorkItem item(const std::string& name, const std::string& word) {
    return {.name = name + "/default", .rawlog = name, .setup = "default", .arguments = {word}};
  }
  std::size_t calls() const {
    const std::string text = readBytes(folder / "calls");
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  TemporaryFolder folder;
  RunStore store{folder / "work"};
  BatchParams params;
};

TEST_F(Runner, RunsEverythingOnceAndContinuesWithWhatIsMissing) {
  const std::vector<WorkItem> items = {item("a", "1"), item("b", "2"), item("c", "3")};
  params.jobs = 2;
  auto result = runBatch({items[0]}, store, params);
  EXPECT_EQ(result.done, 1U);
  result = runBatch(items, store, params);
  EXPECT_EQ(result.done, 3U);
  EXPECT_EQ(result.failed, 0U);
  EXPECT_EQ(calls(), 3U);
  EXPECT_EQ(readBytes(store.folder(items[2]) / "result.txt"), "3\n");
}

TEST_F(Runner, NothingIsSaidOfTheTimeThatRemainsBeforeAnythingWasDone) {
  script("mkdir -p \"$2\"\nsleep 0.3\necho \" 40 %  working\"\nsleep 0.3\n");
  std::vector<BatchProgress> all;
  runBatch({item("a", "1")}, store, params,
           {[&](const BatchProgress& p) { all.push_back(p); }, {}});
  ASSERT_FALSE(all.empty());
  for (const BatchProgress& p : all) EXPECT_EQ(p.remaining_s.has_value(), p.fraction > 0.0);
  EXPECT_FALSE(all.front().remaining_s);
  EXPECT_TRUE(all.back().remaining_s);
}

TEST_F(Runner, ConfigurationsAreCheckedOncePerSetup) {
  script(
      "echo call >> '" + (folder / "calls").string() +
      "'\n[ \"$1\" = --dump-config ] || exit 4\n"
      "if [ \"$2\" = bad ]; then echo 'program.sh: --setup bad: no such setup' >&2; exit 2; fi\n");
  std::vector<WorkItem> items = {item("a", "good"), item("b", "good")};
  requireConfigurations(items, params.program);
  EXPECT_EQ(calls(), 1U);
  items.push_back(item("c", "bad"));
  items.back().setup = "other";
  try {
    requireConfigurations(items, params.program);
    ADD_FAILURE() << "accepted";
  } catch (const ConfigError& e) {
    EXPECT_STREQ(e.what(), "setup other: --setup bad: no such setup");
  }
  EXPECT_THROW(requireConfigurations(items, folder / "missing"), DataError);
  EXPECT_THROW(requireConfigurations(items, "/bin/false"), ConfigError);
}

TEST_F(Runner, TheTableTellsWhyARunIsDoubtful) {
  script("mkdir -p \"$2\"\necho '{\"doubts\": [\"one\", \"two\"]}' > \"$2/summary.json\"\n");
  const std::vector<WorkItem> items = {item("a", "1")};
  runBatch(items, store, params);
  EXPECT_EQ(summaryTable(items, store).rows[0].back(), "one; two");
}

TEST_F(Runner, AFailedRunIsReportedAndTheRestFinished) {
  const std::vector<WorkItem> items = {item("a", "bad"), item("b", "killed"), item("c", "3")};
  std::map<std::string, std::string> ended;
  const auto result = runBatch(
      items, store, params,
      {nullptr, [&](const WorkItem& i, const std::string& failure) { ended[i.name] = failure; }});
  EXPECT_EQ(result.done, 1U);
  EXPECT_EQ(result.failed, 2U);
  EXPECT_EQ(ended["a/default"], "exit status 3: the reason");
  EXPECT_NE(ended["b/default"].find("signal"), std::string::npos);
  EXPECT_EQ(ended["c/default"], "");
  EXPECT_EQ(store.state(items[0]), RunState::kFailed);
  EXPECT_FALSE(fs::exists(store.folder(items[0])));
  const Table table = summaryTable(items, store);
  EXPECT_EQ(table.rows[0][2], "failed");
  EXPECT_EQ(table.rows[0].back(), "exit status 3: the reason");
  EXPECT_EQ(table.rows[2][2], "done");
  // What failed is tried again.
  script("mkdir -p \"$2\"\n");
  EXPECT_EQ(runBatch(items, store, params).done, 3U);
}

TEST_F(Runner, AProgramThatDoesNotExistIsAFailureOfTheRun) {
  params.program = folder / "nowhere";
  const auto result = runBatch({item("a", "1")}, store, params);
  EXPECT_EQ(result.failed, 1U);
  EXPECT_NE(store.failure(item("a", "1")).find("cannot be started"), std::string::npos);
}

TEST_F(Runner, AResultOfOtherArgumentsIsNotTakenForThisOne) {
  runBatch({item("a", "1")}, store, params);
  EXPECT_THROW(runBatch({item("a", "2")}, store, params), ConfigError);
  EXPECT_EQ(calls(), 1U);
}

TEST_F(Runner, AFolderThatIsNotOursIsLeftAlone) {
  fs::create_directories(folder / "work" / "a" / "default");
  writeFile(folder / "work" / "a" / "default" / "precious", "x");
  EXPECT_THROW(runBatch({item("a", "1")}, store, params), DataError);
  EXPECT_EQ(readBytes(folder / "work" / "a" / "default" / "precious"), "x");
}

TEST_F(Runner, LeftoversOfAnInterruptedAttemptAreCleared) {
  const WorkItem a = item("a", "1");
  fs::create_directories(store.unfinishedFolder(a));
  writeFile(store.unfinishedFolder(a) / "leftover", "x");
  runBatch({a}, store, params);
  EXPECT_FALSE(fs::exists(store.folder(a) / "leftover"));
  EXPECT_TRUE(fs::exists(store.folder(a) / "result.txt"));
}

TEST_F(Runner, AnInterruptionStopsTheRunsAndKeepsNothingOfThem) {
  script("mkdir -p \"$2\"\ntrap 'exit 0' TERM\necho started\nwhile true; do sleep 0.02; done\n");
  std::atomic<bool> interrupted{false};
  params.interrupted = &interrupted;
  const std::vector<WorkItem> items = {item("a", "1"), item("b", "2")};
  const auto result = runBatch(items, store, params, {[&](const BatchProgress& p) {
                                 if (p.running == 1) interrupted = true;
                               }});
  EXPECT_TRUE(result.interrupted);
  EXPECT_EQ(result.done, 0U);
  EXPECT_EQ(store.state(items[0]), RunState::kMissing);
  EXPECT_FALSE(fs::exists(store.folder(items[0])));
}

TEST_F(Runner, TwoBatchesDoNotRunTheSameItem) {
  const WorkItem a = item("a", "1");
  const auto lock = RunLock::acquire(store, a);
  ASSERT_TRUE(lock);
  EXPECT_FALSE(RunLock::acquire(store, a));
  const auto result = runBatch({a, item("b", "2")}, store, params);
  EXPECT_EQ(result.elsewhere, 1U);
  EXPECT_EQ(result.done, 1U);
  EXPECT_EQ(calls(), 1U);
}

TEST_F(Runner, ProgressComesFromWhatRunsPrint) {
  EXPECT_EQ(printedFraction(folder / "nothing"), 0.0);
  writeFile(folder / "console", " 10 %  1.0 s of data\n  47 %  5.2 s of data\n");
  EXPECT_DOUBLE_EQ(printedFraction(folder / "console"), 0.47);
  writeFile(folder / "console", "no number here\n");
  EXPECT_EQ(printedFraction(folder / "console"), 0.0);
  double last = 0.0;
  runBatch({item("a", "1"), item("b", "2")}, store, params, {[&](const BatchProgress& p) {
             EXPECT_GE(p.fraction, last);
             last = p.fraction;
           }});
  EXPECT_EQ(last, 1.0);
}

TEST(SummaryTable, CellsAreQuotedForCsvAndAlignedForPeople) {
  const Table table{{"a", "empty", "b"}, {{"1,2", "", "x"}, {"say \"hi\"", "", "long text"}}};
  EXPECT_EQ(tableCsv(table), "a,empty,b\n\"1,2\",,x\n\"say \"\"hi\"\"\",,long text\n");
  EXPECT_EQ(tableText(table), "a         b\n1,2       x\nsay \"hi\"  long text\n");
}

}  // namespace
}  // namespace dynemo::test
