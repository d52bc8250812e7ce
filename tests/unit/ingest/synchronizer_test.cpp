#include "dynemo/ingest/synchronizer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "generated_rawlog.h"

namespace dynemo {
namespace {

using test::at;

struct Event {
  double seconds;
  SensorRole role;
  std::string label;
  std::int64_t entity = 0;
};

TimedItem item(const Event& e) {
  TimedItem out;
  out.stamp = at(e.seconds);
  out.role = e.role;
  out.label = e.label;
  if (e.role == SensorRole::kOdometry) out.payload = OdometryState{test::truePose(e.seconds), {}};
  if (e.role == SensorRole::kDetection) {
    ExternalDetection d;
    d.entity = EntityId{e.entity};
    out.payload = d;
  }
  return out;
}

constexpr auto kScan = SensorRole::kScan;
constexpr auto kImage = SensorRole::kImage;
constexpr auto kDetection = SensorRole::kDetection;

class Synchronizing : public ::testing::Test {
 protected:
  WarningCounter warnings_;

  std::vector<FrameDraft> frames(std::vector<Event> events, SensorRole key) {
    std::stable_sort(events.begin(), events.end(),
                     [](const Event& a, const Event& b) { return a.seconds < b.seconds; });
    Synchronizer synchronizer({}, {}, key, warnings_);
    std::vector<FrameDraft> out;
    for (const Event& e : events) {
      synchronizer.push(item(e));
      while (auto frame = synchronizer.pop()) out.push_back(std::move(*frame));
    }
    synchronizer.finish();
    while (auto frame = synchronizer.pop()) out.push_back(std::move(*frame));
    return out;
  }
  std::uint64_t count(const std::string& part) {
    IngestReport report;
    report.warnings = warnings_.counts();
    return test::warningCount(report, part);
  }
};

double seconds(const TimedItem& i) { return secondsBetween(at(0), i.stamp); }

TEST_F(Synchronizing, TheNearestImageJoins) {
  const auto out = frames({{1.0, kScan, "l"},
                           {0.96, kImage, "c"},
                           {0.99, kImage, "c"},
                           {1.02, kImage, "c"},
                           {2.0, kScan, "l"},
                           {2.049, kImage, "c"},
                           {3.0, kScan, "l"},
                           {3.051, kImage, "c"}},
                          kScan);
  ASSERT_EQ(out.size(), 3U);
  ASSERT_EQ(out[0].images.size(), 1U);
  EXPECT_NEAR(seconds(out[0].images[0]), 0.99, 1e-9);
  EXPECT_EQ(out[1].images.size(), 1U);
  EXPECT_TRUE(out[2].images.empty());
  EXPECT_EQ(count("another one was nearer"), 1U);
  EXPECT_EQ(count("without a frame close enough"), 2U);
}

TEST_F(Synchronizing, AnImageGoesToTheFrameItIsNearestTo) {
  const auto out = frames({{1.00, kScan, "l"}, {1.05, kScan, "l"}, {1.04, kImage, "c"}}, kScan);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_TRUE(out[0].images.empty());
  EXPECT_EQ(out[1].images.size(), 1U);
  EXPECT_TRUE(warnings_.counts().empty());
}

TEST_F(Synchronizing, EachImageIsUsedOnce) {
  const auto out = frames({{1.00, kScan, "l"}, {1.02, kImage, "c"}, {1.04, kScan, "l"}}, kScan);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].images.size() + out[1].images.size(), 1U);
}

TEST_F(Synchronizing, EveryCameraHasItsImage) {
  std::vector<Event> events;
  for (int i = 0; i < 10; ++i) {
    events.push_back({0.1 * i, kScan, "l"});
    events.push_back({0.1 * i + 0.01, kImage, "a"});
    events.push_back({0.1 * i - 0.01, kImage, "b"});
  }
  for (const FrameDraft& f : frames(events, kScan)) EXPECT_EQ(f.images.size(), 2U);
  EXPECT_TRUE(warnings_.counts().empty());
}

TEST_F(Synchronizing, ImagesAloneGroupTheCameras) {
  std::vector<Event> events;
  for (int i = 0; i < 10; ++i) {
    events.push_back({0.033 * i, kImage, "a"});
    if (i % 3 == 0) events.push_back({0.033 * i + 0.013, kImage, "b"});
  }
  events.push_back({5.0, kImage, "b"});
  const auto out = frames(events, kImage);
  ASSERT_EQ(out.size(), 11U);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(out[i].images.size(), i % 3 == 0 ? 2U : 1U) << i;
  EXPECT_EQ(out[10].images[0].label, "b");
}

TEST_F(Synchronizing, EveryEntityIsAStreamOfItsOwn) {
  const auto out = frames({{1.0, kScan, "l"},
                           {1.01, kDetection, "d", 1},
                           {1.015, kDetection, "d", 2},
                           {1.03, kDetection, "d", 1},
                           {1.2, kDetection, "d", 1}},
                          kScan);
  ASSERT_EQ(out.size(), 1U);
  ASSERT_EQ(out[0].detections.size(), 2U);
  EXPECT_NEAR(seconds(out[0].detections[0]), 1.01, 1e-9);
  EXPECT_EQ(count("detection of 'd'"), 2U);
}

TEST_F(Synchronizing, DetectionsAloneFormFramesOfEqualStamps) {
  const auto out = frames({{1.0, kDetection, "d", 1},
                           {1.0, kDetection, "d", 2},
                           {1.01, kDetection, "d", 2},
                           {1.0, kDetection, "e", 1}},
                          kDetection);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].detections.size(), 3U);
  EXPECT_EQ(out[1].detections.size(), 1U);
}

TEST_F(Synchronizing, FramesWaitNoLongerThanNeeded) {
  Synchronizer synchronizer({}, {}, kScan, warnings_);
  std::size_t waiting = 0, most = 0;
  for (int i = 0; i < 500; ++i) {
    synchronizer.push(item({0.1 * i, kScan, "l"}));
    synchronizer.push(item({0.1 * i, kImage, "c"}));
    ++waiting;
    while (synchronizer.pop()) --waiting;
    most = std::max(most, waiting);
  }
  EXPECT_LE(most, 8U);
}

TEST_F(Synchronizing, ImagesWithoutAnyScanDoNotPileUp) {
  Synchronizer synchronizer({}, {}, kScan, warnings_);
  for (int i = 0; i < 500; ++i) {
    synchronizer.push(item({0.1 * i, kImage, "c"}));
    EXPECT_FALSE(synchronizer.pop());
  }
  EXPECT_GE(count("without a frame close enough"), 490U);
}

}  // namespace
}  // namespace dynemo
