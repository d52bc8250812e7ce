// dynemo-optimize on small published graphs and on wrong input.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "process.h"

namespace dynemo::test {
namespace {

namespace fs = std::filesystem;

const fs::path kGraphs = fs::path(DYNEMO_SOURCE_DIR) / "tests/data/pose_graphs";

Outcome optimize(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), DYNEMO_OPTIMIZE);
  return runCommand(arguments);
}

class Optimize : public ::testing::Test {
 protected:
  Optimize()
      : folder_(fs::temp_directory_path() / ("dynemo_optimize_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~Optimize() override { fs::remove_all(folder_); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static std::string read(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  fs::path folder_;
};

TEST_F(Optimize, ReachesThePublishedMinimumFromEitherStart) {
  for (const char* start : {"auto", "file", "chordal"}) {
    const Outcome outcome = optimize({(kGraphs / "smallGrid3D.g2o").string(), "--initial", start});
    EXPECT_EQ(outcome.status, 0) << describe(outcome);
    EXPECT_NE(outcome.out.find("-> 229.0768"), std::string::npos) << outcome.out;
  }
}

TEST_F(Optimize, WritesAGraphThatIsAtItsMinimum) {
  const fs::path out = folder_ / "made" / "out.g2o";
  ASSERT_EQ(optimize({(kGraphs / "smallGrid3D.g2o").string(), "--output", out.string()}).status, 0);
  const Outcome again = optimize({out.string(), "--initial", "file"});
  EXPECT_NE(again.out.find("cost        229.0768"), std::string::npos) << again.out;
  EXPECT_EQ(read(out).find("VERTEX_SE3:QUAT 0 "), 0u);
}

TEST_F(Optimize, TakesMrptsFormat) {
  const fs::path in =
      write("square.graph",
            "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1.2 0 0 0 0 1.5\nVERTEX3 2 1 1.1 0 0 0 3\n"
            "FIX 0\nEDGE3 0 1 1 0 0 0 0 1.5707963\nEDGE3 1 2 1 0 0 0 0 1.5707963\n"
            "EDGE3 2 0 1 1 0 0 0 3.1415926\n");
  const fs::path out = folder_ / "out.graph";
  const Outcome outcome = optimize({in.string(), "-o", out.string()});
  ASSERT_EQ(outcome.status, 0) << describe(outcome);
  EXPECT_NE(read(out).find("EDGE3 1 2 1 0 0 0 0 1.5707963\n"), std::string::npos);
  EXPECT_NE(outcome.out.find("-> 0.000000"), std::string::npos) << outcome.out;
}

TEST_F(Optimize, NamesWhatIsWrong) {
  const auto refused = [](const Outcome& outcome, int status, const std::string& text) {
    EXPECT_EQ(outcome.status, status) << describe(outcome);
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
  };
  refused(optimize({}), 2, "graph is required");
  refused(optimize({"x.g2o", "--initial", "best"}), 2, "--initial");
  refused(optimize({"/nonexistent.g2o"}), 3, "/nonexistent.g2o");
  refused(optimize({write("empty.g2o", "").string()}), 3, "VERTEX");
  refused(optimize({write("lonely.g2o", "VERTEX3 0 0 0 0 0 0 0\n").string()}), 3, "no edge");
  const std::string indefinite =
      "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 8 1 0 0 0 0 0\n"
      "EDGE3 0 8 1 0 0 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 -1\n";
  const std::string file = write("indefinite.graph", indefinite).string();
  refused(optimize({file}), 3, "line 3: the information matrix of edge 0 -> 8");
  EXPECT_NE(optimize({file, "--repair"}).out.find("repaired    1"), std::string::npos);
  // Before anything is worked out.
  const Outcome nowhere =
      optimize({(kGraphs / "tinyGrid3D.g2o").string(), "-o", file + "/out.g2o"});
  refused(nowhere, 3, "out.g2o: cannot be written: Not a directory");
  EXPECT_EQ(nowhere.out, "");
}

TEST_F(Optimize, HelpAndVersion) {
  EXPECT_EQ(optimize({"--help"}).status, 0);
  EXPECT_EQ(optimize({"--version"}).out, "dynemo-optimize " DYNEMO_VERSION "\n");
}

}  // namespace
}  // namespace dynemo::test
