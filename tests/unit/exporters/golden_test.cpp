// The text formats, byte by byte. A wanted change of a format is written by running this test with
// the variable DYNEMO_UPDATE_GOLDEN set.
#include <gtest/gtest.h>

#include <algorithm>
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
                                           std::pair("entities", "entities.csv"),
                                           std::pair("tum", "poses.txt"),
                                           std::pair("csv", "tables.txt"),
                                           std::pair("spark-dsg", "scene_graph.json")),
                         [](const auto& param_info) {
                           std::string name = param_info.param.first;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace dynemo::test
