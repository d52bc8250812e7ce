#include "dynemo/ingest/external_files.h"

#include <gtest/gtest.h>

#include "dynemo/ingest/rawlog_source.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

TEST(ExternalFiles, TriesTheFoldersOfMrptInOrder) {
  const TemporaryFolder folder;
  const fs::path log = folder / "run.rawlog";
  EXPECT_EQ(ExternalFiles(log).folder().filename(), "Images");
  for (const char* name : {"run_IMAGES", "run_images", "run_Images"}) {
    fs::create_directory(folder / name);
    EXPECT_EQ(ExternalFiles(log).folder().filename(), name);
  }
  EXPECT_TRUE(ExternalFiles(log).folder().is_absolute());
}

TEST(ExternalFiles, FindsRelativeAndAbsoluteNames) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "run_Images/sub");
  writeFile(folder / "run_Images/sub/a.png", "a");
  writeFile(folder / "b.png", "b");
  const ExternalFiles files(folder / "run.rawlog");
  EXPECT_EQ(files.find("sub/a.png"), folder / "run_Images/sub/a.png");
  EXPECT_EQ(files.find((folder / "b.png").string()), folder / "b.png");
  EXPECT_FALSE(files.find("missing.png"));
  EXPECT_FALSE(files.find(""));
  EXPECT_FALSE(files.find("sub"));
  EXPECT_FALSE(files.find(std::string("sub/a.png\0x", 11)));
}

TEST(ExternalFiles, ImagesAreFoundFromAnyWorkingFolder) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "run_Images");
  {
    RawlogWriter out(folder / "run.rawlog");
    for (int i = 0; i < 5; ++i) {
      auto image = imageObservation(0.1 * i);
      image.image.saveToFile(folder / "run_Images/a.png");
      image.image.setExternalStorage("a.png");
      out.write(image);
    }
  }
  const fs::path before = fs::current_path();
  fs::current_path(folder / "run_Images");
  const auto source = makeRawlogSource({}, fs::path("../run.rawlog"));
  fs::current_path(before);
  const auto frames = allFrames(*source);
  ASSERT_EQ(frames.size(), 5U);
  EXPECT_EQ(frames[4].images[0].grey.at<std::uint8_t>(3, 5), 16);
}

}  // namespace
}  // namespace dynemo
