// Loop closure over whole sample recordings: which closures are found, whether they are right, and
// what they do to the trajectory.
#include <gtest/gtest.h>

#include <iostream>

#include "sample_dataset.h"
#include "sample_runs.h"

namespace dynemo {
namespace {

constexpr double kMinRecall = 0.8;
constexpr double kNoChange_m = 3e-5;

struct Case {
  const char* name;
  double odometry_error;
  double max_ate_m;
};

class SampleLoops : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const auto folder = test::samplesFolder();
    if (!folder) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
    samples_ = *folder;
  }
  void report(const char* what, const test::SampleRun& run, const LoopReport& loops) const {
    std::cout << GetParam().name << ", odometry error x" << GetParam().odometry_error << ", "
              << what << ": ATE " << 100 * run.ate_m() << " cm, " << loops.closures << " closures, "
              << loops.right << " right, recall " << loops.recalled << "/" << loops.closable << ", "
              << loops.removed << " taken out, median error "
              << 100 * loops.errors.translation_m.median << " cm, worst "
              << 100 * loops.errors.translation_m.max << " cm\n";
  }
  std::filesystem::path samples_;
};

TEST_P(SampleLoops, AreRightAndFoundAndHelp) {
  DynemoParams params;
  const auto run = test::runSample(samples_, GetParam().name, params, GetParam().odometry_error);
  const LoopReport loops = run.loops(params.loops.candidates);
  report("loops closed", run, loops);
  EXPECT_EQ(loops.right, loops.closures);
  EXPECT_GE(loops.recall(), kMinRecall);
  EXPECT_GE(loops.closable, 10u);
  EXPECT_LE(run.ate_m(), GetParam().max_ate_m);

  params.loops.enabled = false;
  const auto open = test::runSample(samples_, GetParam().name, params, GetParam().odometry_error);
  report("loops open", open, open.loops(params.loops.candidates));
  // Where walls hold the trajectory already, closures change it by the noise of the scans.
  EXPECT_LE(run.ate_m(), open.ate_m() + kNoChange_m);
}

INSTANTIATE_TEST_SUITE_P(
    Simulated, SampleLoops,
    testing::Values(Case{"mini_samo", 1.0, 0.019}, Case{"mini_mamo", 1.0, 0.014},
                    Case{"mini_samo", 2.0, 0.04}, Case{"mini_mamo", 2.0, 0.03}),
    [](const auto& test) {
      return std::string(test.param.name) +
             (test.param.odometry_error > 1.0 ? "_odometry_error_doubled" : "");
    });

}  // namespace
}  // namespace dynemo
