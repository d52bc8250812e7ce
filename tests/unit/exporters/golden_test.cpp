// The text formats, byte by byte. A wanted change of a format is written by running this test with
// the variable DYNEMO_UPDATE_GOLDEN set.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "small_run.h"

namespace dynemo::test {
namespace {

class Golden : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Golden, MatchesTheStoredFile) {
  const auto& [exporter, file_name] = GetParam();
  const auto golden = std::filesystem::path(GOLDEN_FOLDER) / file_name;
  const SmallRun run = smallRun();
  const std::string text = exported(exporter, run.result());
  if (std::getenv("DYNEMO_UPDATE_GOLDEN")) std::ofstream(golden, std::ios::binary) << text;
  EXPECT_EQ(text, readFile(golden));
}

INSTANTIATE_TEST_SUITE_P(TextFormats, Golden,
                         ::testing::Values(std::pair("trajectory", "trajectory.tum"),
                                           std::pair("keyframes", "keyframes.tum"),
                                           std::pair("odometry", "odometry.tum"),
                                           std::pair("entities", "entities.csv")),
                         [](const auto& param_info) {
                           return std::string(param_info.param.first);
                         });

}  // namespace
}  // namespace dynemo::test
