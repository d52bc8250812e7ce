// Results that are complete or absent, and the images that go with them.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationImage.h>

#include <sys/resource.h>

#include <csignal>
#include <opencv2/imgcodecs.hpp>

#include "dynemo/core/error.h"
#include "dynemo/prep/rewrite.h"
#include "generated_rawlog.h"
#include "written_log.h"

namespace dynemo::test {
namespace {

class Output : public ::testing::Test {
 protected:
  /// A log with one external image per name, whose content is the name.
  void writeExternal(const fs::path& file, const std::vector<std::string>& names,
                     const std::string& content, double start_s = 0.0) {
    const fs::path images = file.parent_path() / (file.stem().string() + "_Images");
    fs::create_directories(images);
    RawlogWriter out(file);
    double t = start_s;
    for (const std::string& name : names) {
      auto o = imageObservation(t += 0.1);
      o.image.setExternalStorage(name);
      out.write(o);
      if (!content.empty()) writeFile(images / name, content + name);
    }
  }
  TemporaryFolder folder;
  fs::path input = folder / "in.rawlog", output = folder / "out.rawlog";
};

TEST_F(Output, IsNeverOverwritten) {
  writeLog(input, {.duration_s = 1});
  const std::string before = readBytes(input);
  EXPECT_THROW(trimRawlog(input, input, {}, {}), DataError);
  EXPECT_EQ(readBytes(input), before);
  fs::create_directories(folder / "out_Images");
  EXPECT_THROW(trimRawlog(input, output, {}, {}), DataError);
  EXPECT_THROW(trimRawlog(input, folder / "out.bag", {}, {}), ConfigError);
  EXPECT_EQ(filesIn(folder / ""), (std::vector<std::string>{"in.rawlog", "out_Images"}));
}

TEST_F(Output, TakesAlongTheImagesOfWhatIsKept) {
  writeExternal(input, {"a.png", "b.png", "c.png"}, "bytes of ");
  trimRawlog(input, output, {.from_s = 0.05, .to_s = 0.15}, {});
  EXPECT_EQ(filesIn(folder / "out_Images"), std::vector<std::string>{"b.png"});
  EXPECT_EQ(readBytes(folder / "out_Images" / "b.png"), "bytes of b.png");
}

/// The message of the error; empty without one.
template <class Action>
std::string messageOf(const Action& action) {
  try {
    action();
  } catch (const DataError& e) {
    return e.what();
  }
  return {};
}

TEST_F(Output, AFullDiskIsSaidToBeFull) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  writeLog(input, {.duration_s = 20});
  for (const bool compressed : {false, true}) {
    fs::create_symlink("/dev/full", folder / "out.rawlog.part");
    const std::string message =
        messageOf([&] { trimRawlog(input, output, {}, {.compressed = compressed}); });
    EXPECT_NE(message.find("cannot be written: No space left on device"), std::string::npos)
        << message;
  }
  EXPECT_EQ(filesIn(folder / ""), std::vector<std::string>{"in.rawlog"});
}

TEST_F(Output, AnImageThatDoesNotFitIsSaidNotToFit) {
  writeExternal(input, {"a.jpg"}, std::string(300'000, 'x'));
  // A limit in the middle of the file stands for a disk that gets full there.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100'000, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = messageOf([&] { trimRawlog(input, output, {}, {}); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find("a.jpg: cannot be written: File too large"), std::string::npos) << message;
  EXPECT_EQ(filesIn(folder / ""), (std::vector<std::string>{"in.rawlog", "in_Images"}));
}

TEST_F(Output, LinksInsteadOfCopyingWhenAsked) {
  writeExternal(input, {"a.png"}, "bytes of ");
  trimRawlog(input, output, {}, {.images = ImageTransfer::kHardLink});
  EXPECT_EQ(fs::hard_link_count(folder / "out_Images" / "a.png"), 2U);
}

TEST_F(Output, CountsMissingImages) {
  writeExternal(input, {"a.png", "b.png"}, "");
  const auto report = trimRawlog(input, output, {}, {});
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_EQ(report.warnings.begin()->second, 2U);
  EXPECT_NE(report.warnings.begin()->first.find("a.png"), std::string::npos);
  EXPECT_EQ(readLog(output).size(), 2U);
}

TEST_F(Output, RefusesNamesThatLeaveTheFolder) {
  writeFile(folder / "secret.png", "x");
  writeExternal(input, {"../secret.png"}, "");
  const auto report = trimRawlog(input, output, {}, {});
  EXPECT_EQ(report.warnings.size(), 1U);
  EXPECT_EQ(filesIn(folder / ""),
            (std::vector<std::string>{"in.rawlog", "in_Images", "out.rawlog", "secret.png"}));
}

TEST_F(Output, MergedImagesOfTheSameNameKeepTheirContents) {
  writeExternal(folder / "a.rawlog", {"same.png", "x.png"}, "first ");
  writeExternal(folder / "b.rawlog", {"same.png", "y.png"}, "second ", 10.0);
  mergeRawlogs({folder / "a.rawlog", folder / "b.rawlog"}, output, {});
  std::vector<std::string> contents;
  for (const auto& o : readLog(output)) {
    const auto& image = dynamic_cast<mrpt::obs::CObservationImage&>(*o.object).image;
    contents.push_back(readBytes(folder / "out_Images" / image.getExternalStorageFile()));
  }
  EXPECT_EQ(contents, (std::vector<std::string>{"first same.png", "first x.png", "second same.png",
                                                "second y.png"}));
}

TEST_F(Output, ExternalisedImagesHaveTheSamePixels) {
  {
    RawlogWriter out(input);
    out.write(imageObservation(0.0, "camera", 1));
    out.write(imageObservation(0.0, "camera", 1));  // the same label and stamp
    out.write(poseObservation(0.1));
    out.write(imageObservation(0.2, "left/colour", 3));
  }
  const auto report = externalizeImages(input, output, ImageFormat::kPng, 95, {});
  EXPECT_EQ(report.edited,
            (std::map<std::string, std::uint64_t>{{"camera", 2}, {"left/colour", 1}}));
  const auto before = readLog(input), after = readLog(output);
  ASSERT_EQ(after.size(), 4U);
  EXPECT_EQ(after[2].bytes, before[2].bytes);
  for (const std::size_t i : {0U, 1U, 3U}) {
    const auto& was = dynamic_cast<mrpt::obs::CObservationImage&>(*before[i].object);
    const auto& is = dynamic_cast<mrpt::obs::CObservationImage&>(*after[i].object);
    ASSERT_TRUE(is.image.isExternallyStored());
    const fs::path file = folder / "out_Images" / is.image.getExternalStorageFile();
    const cv::Mat pixels = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    const auto expected = was.image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY);
    ASSERT_EQ(pixels.size(), expected.size()) << file;
    EXPECT_EQ(cv::norm(pixels, expected, cv::NORM_INF), 0.0) << file;
    EXPECT_EQ(is.cameraParams.fx(), was.cameraParams.fx());
  }
  EXPECT_EQ(filesIn(folder / "out_Images").size(), 3U);

  const auto again = externalizeImages(output, folder / "again.rawlog", ImageFormat::kPng, 95, {});
  EXPECT_TRUE(again.edited.empty());
  EXPECT_EQ(again.warnings, (std::map<std::string, std::uint64_t>{
                                {"image that is in a file already and stays there", 3}}));
}

TEST_F(Output, ALogWithoutImagesHasNoneToExternalise) {
  {
    RawlogWriter out(input);
    out.write(poseObservation(0.1));
  }
  EXPECT_THROW(externalizeImages(input, output, ImageFormat::kPng, 95, {}), DataError);
  EXPECT_FALSE(fs::exists(output));
}

}  // namespace
}  // namespace dynemo::test
