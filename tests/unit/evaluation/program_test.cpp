// dynemo-eval as a user runs it: exit statuses and files.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "example_run.h"

namespace dynemo::test {
namespace {

class Program : public ::testing::Test {
 protected:
  void SetUp() override {
    writeTum(curve(50), folder_.path() / "gt.tum");
    writeTum(transformedCurve(), folder_.path() / "trajectory.tum");
  }
  static Trajectory transformedCurve() {
    Trajectory t = curve(50);
    for (auto& pose : t) pose.T = Pose3::translation(1, 2, 3) * pose.T;
    return t;
  }
  std::string inFolder(const std::string& name) const {
    return " '" + (folder_.path() / name).string() + "'";
  }
  int run(const std::string& arguments) const {
    const std::string command = std::string("'") + DYNEMO_EVAL_PROGRAM + "' " + arguments + " >" +
                                inFolder("out.txt") + " 2>" + inFolder("err.txt");
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string text(const std::string& name) const {
    std::ifstream in(folder_.path() / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  Folder folder_;
};

TEST_F(Program, PrintsATableAndWritesJson) {
  EXPECT_EQ(run("--reference" + inFolder("gt.tum") + " --json" + inFolder("r.json") + inFolder("")),
            0);
  EXPECT_NE(text("out.txt").find("ATE [m]"), std::string::npos);
  EXPECT_NEAR(nlohmann::json::parse(text("r.json"))["trajectory"]["ate_m"]["rmse"].get<double>(),
              0.0, 1e-6);
}

TEST_F(Program, HelpAndVersionSucceed) {
  EXPECT_EQ(run("--help"), 0);
  EXPECT_NE(text("out.txt").find("--entities-reference"), std::string::npos);
  EXPECT_EQ(run("--version"), 0);
  EXPECT_NE(text("out.txt").find("dynemo-eval "), std::string::npos);
}

TEST_F(Program, WrongUsageIsStatus2) {
  EXPECT_EQ(run(""), 2);
  EXPECT_EQ(run("--reference" + inFolder("gt.tum")), 2);
  EXPECT_EQ(run("--reference" + inFolder("gt.tum") + " --unknown" + inFolder("")), 2);
  EXPECT_EQ(run("--reference" + inFolder("gt.tum") + " --entities-reference x.csv" +
                inFolder("trajectory.tum")),
            2);
}

TEST_F(Program, WrongDataIsStatus3AndOneLine) {
  EXPECT_EQ(run("--reference" + inFolder("none.tum") + inFolder("")), 3);
  const std::string message = text("err.txt");
  EXPECT_NE(message.find("none.tum"), std::string::npos);
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 1);
  EXPECT_EQ(run("--reference" + inFolder("gt.tum") + " /nonexistent"), 3);
  EXPECT_EQ(run("--reference" + inFolder("gt.tum") + " --json" + inFolder("gt.tum/r.json") +
                inFolder("")),
            3);
}

}  // namespace
}  // namespace dynemo::test
