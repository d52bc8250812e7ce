// What every exporter owes, whatever its format.
#include <gtest/gtest.h>

#include "dynemo/core/error.h"
#include "dynemo/exporters/exporter.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

class EveryExporter : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryExporter, WritesTheSameBytesTwice) {
  const SmallRun first = smallRun(), second = smallRun();
  const std::string bytes = exported(GetParam(), first.result());
  EXPECT_FALSE(bytes.empty());
  EXPECT_TRUE(bytes == exported(GetParam(), second.result()));
}

TEST_P(EveryExporter, WritesAnEmptyRun) {
  const SmallRun empty;
  EXPECT_NO_THROW(exported(GetParam(), empty.result()));
}

TEST_P(EveryExporter, LeavesNothingBesideItsFile) {
  const TemporaryFolder folder;
  const SmallRun run = smallRun();
  const auto exporter = exporters().make(GetParam());
  exporter->write(run.result(), folder.path() / exporter->fileName());
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    files.push_back(entry.path().filename().string());
  }
  EXPECT_EQ(files, std::vector<std::string>{exporter->fileName()});
}

TEST_P(EveryExporter, NamesTheFileItCannotWrite) {
  const SmallRun run = smallRun();
  const auto exporter = exporters().make(GetParam());
  const auto file = std::filesystem::path("/nonexistent-folder") / exporter->fileName();
  try {
    exporter->write(run.result(), file);
    FAIL() << "written to a folder that does not exist";
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find(file.string()), std::string::npos) << e.what();
  }
}

TEST_P(EveryExporter, NoticesAFullDisk) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  const TemporaryFolder folder;
  const SmallRun run = smallRun();
  const auto exporter = exporters().make(GetParam());
  const auto file = folder.path() / exporter->fileName();
  std::filesystem::create_symlink("/dev/full", file.string() + ".part");
  EXPECT_THROW(exporter->write(run.result(), file), DataError);
  EXPECT_FALSE(std::filesystem::exists(file));
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryExporter, ::testing::ValuesIn(exporters().names()),
                         [](const auto& param_info) { return "output_" + param_info.param; });

TEST(ExporterRegistry, HasTheDocumentedFormats) {
  for (const char* name :
       {"trajectory", "keyframes", "odometry", "entities", "g2o", "graph", "3dscene", "map"}) {
    EXPECT_TRUE(exporters().contains(name)) << name;
  }
}

TEST(ExporterRegistry, RefusesAnUnknownFormatByName) {
  EXPECT_THROW(exporters().make("vrml"), ConfigError);
}

}  // namespace
}  // namespace dynemo::test
