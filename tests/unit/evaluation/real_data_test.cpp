// Recorded trajectories with figures computed by other programs.
#include <gtest/gtest.h>

#include <cstdlib>

#include "dynemo/evaluation/trajectory_error.h"
#include "example_run.h"

namespace dynemo::test {
namespace {

TEST(RealData, AteEqualsWhatEvoPrints) {
  const char* folder = std::getenv("DYNEMO_REAL_DATA");
  if (!folder) GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
  constexpr double kTolerance = 1e-6;
  const auto data = std::filesystem::path(folder) / "eval";
  const auto aligned = alignTrajectories(readTum(data / "fr2_desk_groundtruth.txt"),
                                         readTum(data / "fr2_desk_ORB.txt"));
  ASSERT_TRUE(aligned);
  const Statistics ate = absoluteTranslationError(*aligned);
  EXPECT_EQ(ate.count, 2174u);
  EXPECT_NEAR(ate.rmse, 0.008119, kTolerance);
  EXPECT_NEAR(ate.mean, 0.007492, kTolerance);
  EXPECT_NEAR(ate.median, 0.007415, kTolerance);
  EXPECT_NEAR(ate.std, 0.003129, kTolerance);
  EXPECT_NEAR(ate.min, 0.000350, kTolerance);
  EXPECT_NEAR(ate.max, 0.024300, kTolerance);
}

}  // namespace
}  // namespace dynemo::test
