#include "dynemo/core/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "dynemo/core/error.h"

namespace dynemo::test {
namespace {

namespace fs = std::filesystem;

class OutputFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("dynemo_output_file_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  static std::string contentOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  fs::path folder_;
};

TEST_F(OutputFile, AppendedLinesAreThereAtOnce) {
  AppendFile file(folder_ / "log.csv");
  file.line("a,b");
  EXPECT_EQ(contentOf(folder_ / "log.csv"), "a,b\n");
  file.line("1,2");
  EXPECT_EQ(contentOf(folder_ / "log.csv"), "a,b\n1,2\n");
}

TEST_F(OutputFile, AppendFileStartsAnew) {
  AppendFile(folder_ / "log.csv").line("old");
  AppendFile(folder_ / "log.csv").line("new");
  EXPECT_EQ(contentOf(folder_ / "log.csv"), "new\n");
}

TEST_F(OutputFile, FullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  AppendFile file("/dev/full");
  EXPECT_THROW(file.line("text"), DataError);
  EXPECT_THROW(file.line("text"), DataError) << "and stays one";
}

TEST_F(OutputFile, MissingFolderIsAnError) {
  EXPECT_THROW(AppendFile(folder_ / "missing" / "log.csv"), DataError);
  try {
    writeFileAtomically(folder_ / "missing" / "x.txt", "x");
    ADD_FAILURE() << "written";
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find("folder does not exist"), std::string::npos) << e.what();
  }
}

TEST_F(OutputFile, TheFolderOfAFileIsMadeBeforehand) {
  for (const fs::path& file : {folder_ / "a" / "b" / "x.txt", folder_ / "c" / "d" / ""}) {
    prepareFolderOf(file);
    EXPECT_TRUE(fs::is_directory(folder_ / "a" / "b"));
  }
  EXPECT_TRUE(fs::is_directory(folder_ / "c"));
  EXPECT_FALSE(fs::exists(folder_ / "c" / "d"));
  writeFileAtomically(folder_ / "a" / "b" / "x.txt", "x");
  for (const fs::path& file : {folder_ / "a" / "b" / "x.txt" / "y", fs::path("/proc/nowhere/y")}) {
    try {
      prepareFolderOf(file);
      ADD_FAILURE() << file << " can be made";
    } catch (const DataError& e) {
      EXPECT_NE(std::string(e.what()).find(file.string() + ": cannot be written: "),
                std::string::npos)
          << e.what();
    }
  }
}

TEST_F(OutputFile, AtomicWriteLeavesLinksAndPipesWhatTheyAre) {
  writeFileAtomically(folder_ / "there.txt", "old");
  fs::create_symlink(folder_ / "there.txt", folder_ / "link.txt");
  writeFileAtomically(folder_ / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(contentOf(folder_ / "there.txt"), "new");

  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  writeFileAtomically(pipe, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
  char read_back[16] = {};
  EXPECT_EQ(read(reader, read_back, sizeof(read_back)), 7);
  EXPECT_STREQ(read_back, "through");
  close(reader);
}

TEST_F(OutputFile, AtomicWriteReplacesAndLeavesNothingBehind) {
  writeFileAtomically(folder_ / "x.txt", "first");
  writeFileAtomically(folder_ / "x.txt", std::string("second\0half", 11));
  EXPECT_EQ(contentOf(folder_ / "x.txt"), std::string("second\0half", 11));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(OutputFile, AFolderIsReplacedAsAWhole) {
  writeFolderAtomically(folder_ / "set", {{"a.txt", "1"}, {"b.txt", "2"}});
  writeFolderAtomically(folder_ / "set", {{"a.txt", "3"}});
  EXPECT_EQ(contentOf(folder_ / "set" / "a.txt"), "3");
  EXPECT_FALSE(fs::exists(folder_ / "set" / "b.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(OutputFile, AFailedFolderKeepsWhatWasThere) {
  writeFolderAtomically(folder_ / "set", {{"a.txt", "1"}});
  EXPECT_THROW(writeFolderAtomically(folder_ / "set", {{"no/b.txt", "2"}}), DataError);
  EXPECT_EQ(contentOf(folder_ / "set" / "a.txt"), "1");
  EXPECT_FALSE(fs::exists(folder_ / "set.part"));
  writeFileAtomically(folder_ / "x.txt", "mine");
  EXPECT_THROW(writeFolderAtomically(folder_ / "x.txt", {{"a.txt", "1"}}), DataError);
  EXPECT_EQ(contentOf(folder_ / "x.txt"), "mine");
}

TEST_F(OutputFile, AFolderWithOtherThingsInItIsNotReplaced) {
  writeFolderAtomically(folder_ / "set", {{"a.txt", "1"}});
  const auto expectKept = [&](const fs::path& other) {
    try {
      writeFolderAtomically(folder_ / "set", {{"a.txt", "2"}});
      ADD_FAILURE() << "replaced";
    } catch (const DataError& e) {
      EXPECT_NE(std::string(e.what()).find(other.filename().string()), std::string::npos)
          << e.what();
    }
    EXPECT_EQ(contentOf(folder_ / "set" / "a.txt"), "1");
    EXPECT_TRUE(fs::exists(other));
    fs::remove_all(other);
  };
  writeFileAtomically(folder_ / "set" / "thesis.tex", "years of work");
  expectKept(folder_ / "set" / "thesis.tex");
  fs::create_directory(folder_ / "set" / "photos");
  expectKept(folder_ / "set" / "photos");
  writeFolderAtomically(folder_ / "set", {{"a.txt", "2"}});
  EXPECT_EQ(contentOf(folder_ / "set" / "a.txt"), "2");
}

TEST_F(OutputFile, FailedAtomicWriteKeepsWhatWasThere) {
  fs::create_directories(folder_ / "x.txt" / "occupied");
  EXPECT_THROW(writeFileAtomically(folder_ / "x.txt", "text"), DataError);
  EXPECT_TRUE(fs::exists(folder_ / "x.txt" / "occupied"));
  EXPECT_FALSE(fs::exists(folder_ / "x.txt.part"));
}

TEST_F(OutputFile, ExactNumbersReadBack) {
  for (const double v : {0.1, 1.0 / 3.0, 1e-300, -2.5e17, 5e-324, 1700000030.1234567, 0.0}) {
    EXPECT_EQ(std::strtod(exactNumber(v).c_str(), nullptr), v);
  }
  EXPECT_EQ(exactNumber(0.1), "0.1");
}

}  // namespace
}  // namespace dynemo::test
