// The recorded samples named by the environment variable DYNEMO_SAMPLES.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "dynemo/ingest/rawlog_source.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

struct SampleCase {
  const char* name;
  std::uint64_t frames;
};

class Samples : public testing::TestWithParam<SampleCase> {};

TEST_P(Samples, EveryScanHasItsImageAndOdometry) {
  const char* folder = std::getenv("DYNEMO_SAMPLES");
  if (folder == nullptr) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
  const std::string name = GetParam().name;
  const auto source = makeRawlogSource({}, fs::path(folder) / name / (name + ".rawlog"));
  std::optional<Stamp> last;
  while (const auto frame = source->next()) {
    ASSERT_TRUE(!last || frame->stamp > *last);
    last = frame->stamp;
    ASSERT_TRUE(frame->scan);
    EXPECT_GT(frame->scan->cloud.size(), 1000U);
    EXPECT_EQ(frame->scan->stamp, frame->stamp);
    ASSERT_EQ(frame->images.size(), 1U);
    const CameraImage& image = frame->images[0];
    EXPECT_EQ(image.grey.cols, image.model.width);
    EXPECT_TRUE(image.model.valid());
    ASSERT_TRUE(image.odometry);
    EXPECT_TRUE(image.odometry->accumulated_covariance);
    ASSERT_TRUE(frame->odometry);
  }
  const IngestReport& report = source->report();
  EXPECT_EQ(report.frames, GetParam().frames);
  EXPECT_EQ(report.observations.at("lidar (CObservationPointCloud)"), GetParam().frames);
  for (const auto& [what, times] : report.warnings) {
    EXPECT_EQ(what, "cloud: points out of range removed") << times;
  }
}

INSTANTIATE_TEST_SUITE_P(Mini, Samples,
                         testing::Values(SampleCase{"mini_samo", 286},
                                         SampleCase{"mini_mamo", 261}),
                         [](const auto& sample) { return std::string(sample.param.name); });

}  // namespace
}  // namespace dynemo
