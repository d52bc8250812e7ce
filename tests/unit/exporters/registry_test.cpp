// What every exporter owes, whatever its format.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>

#include "dynemo/core/error.h"
#include "dynemo/exporters/exporter.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

/// Small pictures, so that software rendering takes no time.
ExportParams smallPictures() {
  ExportParams params;
  params.png.width_px = 96;
  params.png.height_px = 72;
  return params;
}

class EveryExporter : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryExporter, WritesTheSameBytesTwice) {
  const SmallRun first = smallRun(), second = smallRun();
  const std::string bytes = exported(GetParam(), first.result(), smallPictures());
  EXPECT_FALSE(bytes.empty());
  EXPECT_TRUE(bytes == exported(GetParam(), second.result(), smallPictures()));
}

TEST_P(EveryExporter, WritesAnEmptyRun) {
  const SmallRun empty;
  EXPECT_NO_THROW(exported(GetParam(), empty.result(), smallPictures()));
}

TEST_P(EveryExporter, LeavesNothingBesideItsFile) {
  const TemporaryFolder folder;
  const SmallRun run = smallRun();
  const auto exporter = exporters().make(GetParam(), smallPictures());
  exporter->write(run.result(), folder.path() / exporter->fileName());
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    files.push_back(entry.path().filename().string());
  }
  EXPECT_EQ(files, std::vector<std::string>{exporter->fileName()});
}

TEST_P(EveryExporter, NamesTheFileItCannotWrite) {
  const SmallRun run = smallRun();
  const auto exporter = exporters().make(GetParam(), smallPictures());
  const auto file = std::filesystem::path("/nonexistent-folder") / exporter->fileName();
  try {
    exporter->write(run.result(), file);
    FAIL() << "written to a folder that does not exist";
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find(file.string()), std::string::npos) << e.what();
  }
}

/// Files cannot grow beyond a few bytes while it lives, as on a full disk.
class FullDisk {
 public:
  FullDisk() {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_limit_);
    rlimit tiny = old_limit_;
    tiny.rlim_cur = 8;
    setrlimit(RLIMIT_FSIZE, &tiny);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &old_limit_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit old_limit_{};
  void (*old_handler_)(int) = nullptr;
};

TEST_P(EveryExporter, NoticesAFullDisk) {
  const TemporaryFolder folder;
  const SmallRun run = smallRun();
  const auto exporter = exporters().make(GetParam(), smallPictures());
  const auto file = folder.path() / exporter->fileName();
  {
    const FullDisk full;
    EXPECT_THROW(exporter->write(run.result(), file), DataError);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryExporter, ::testing::ValuesIn(exporters().names()),
                         [](const auto& param_info) {
                           std::string name = "output_" + param_info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(ExporterRegistry, HasTheDocumentedFormats) {
  for (const char* name :
       {"trajectory", "keyframes", "odometry", "entities", "tum", "csv", "ply", "pcd", "g2o",
        "graph", "gltf", "spark-dsg", "3dscene", "png", "html", "map"}) {
    EXPECT_TRUE(exporters().contains(name)) << name;
  }
}

TEST(ExporterRegistry, RefusesAnUnknownFormatByName) {
  EXPECT_THROW(exporters().make("vrml", ExportParams()), ConfigError);
}

}  // namespace
}  // namespace dynemo::test
