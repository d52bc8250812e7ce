#include "dynemo/pipeline/front_end_cache.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

/// One entity per frame, at a place that the stamp tells, and a warning for each.
class StampDetector : public EntityDetector {
 public:
  std::vector<EntityObservation> detect(const SensorFrame& frame) override {
    ++warnings_["seen"];
    EntityObservation o;
    o.entity = EntityId{7};
    o.semantic_class = SemanticClass::kAgent;
    o.name = "walker";
    o.stamp = frame.stamp;
    o.T_base_entity = Pose3::fromYawPitchRoll(frame.stamp.seconds(), 0.1, 0.2, 0.3, 0.4, 0.5);
    o.covariance = 0.01 * Matrix6::Identity();
    o.tag_count = 2;
    o.sensor_label = "camera";
    return {o};
  }
};

class NoDetector : public EntityDetector {
 public:
  std::vector<EntityObservation> detect(const SensorFrame&) override {
    ADD_FAILURE() << "must be replayed";
    return {};
  }
};

/// Every scan fails in the way that its stamp tells.
class FailingOdometry : public ScanOdometry {
 public:
  Expected<OdometryEstimate, OdometryFailure> update(const Scan& scan,
                                                     const std::optional<OdometryState>&,
                                                     std::span<const std::uint32_t>) override {
    return make_unexpected(scan.stamp.ns % 2 == 0 ? OdometryFailure::kNoOverlap
                                                  : OdometryFailure::kNotConverged);
  }
};

/// One plane, whose number of calls a test can ask for.
class CountingExtractor : public PlaneExtractor {
 public:
  explicit CountingExtractor(int& calls) : calls_(calls) {}
  std::vector<PlaneObservation> extract(const Scan& scan) const override {
    ++calls_;
    PlaneObservation plane;
    plane.patch_base.center = scan.cloud.points.front().cast<double>() / 3.0;
    plane.patch_base.normal = Vector3(0.6, 0.0, 0.8);
    plane.patch_base.cells = {{1, -2}, {300, 4}};
    plane.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
    plane.rms_m = 0.1;
    plane.points = {0, 7, 9};
    return {plane, plane};
  }

 private:
  int& calls_;
};

class FrontEndCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove(file_);
    fs::remove_all(file_.string() + ".planes");
  }

  static SensorFrame frame(std::int64_t ns) {
    SensorFrame f;
    f.stamp = Stamp{ns};
    return f;
  }
  static Scan scan(std::int64_t ns) {
    Scan s;
    s.stamp = Stamp{ns};
    return s;
  }

  void record(std::int64_t frames, bool finish = true) const {
    FrontEndCache cache(file_, "one");
    EXPECT_FALSE(cache.replays());
    const auto detector = cache.wrap(std::make_unique<StampDetector>());
    const auto odometry = cache.wrap(std::make_unique<FailingOdometry>());
    for (std::int64_t ns = 1; ns <= frames; ++ns) {
      EXPECT_FALSE(odometry->update(scan(ns), std::nullopt));
      detector->detect(frame(ns));
    }
    if (finish) cache.finish();
  }

  const fs::path file_ = fs::path(testing::TempDir()) / "front_end.cache";
};

TEST_F(FrontEndCacheTest, ReplaysWhatWasRecorded) {
  record(3);
  FrontEndCache cache(file_, "one");
  ASSERT_TRUE(cache.replays());
  const auto detector = cache.wrap(std::make_unique<NoDetector>());
  const auto odometry = cache.wrap(std::make_unique<FailingOdometry>());
  StampDetector original;
  for (std::int64_t ns = 1; ns <= 3; ++ns) {
    EXPECT_EQ(odometry->update(scan(ns), std::nullopt).error(),
              ns % 2 == 0 ? OdometryFailure::kNoOverlap : OdometryFailure::kNotConverged);
    const auto replayed = detector->detect(frame(ns)), expected = original.detect(frame(ns));
    ASSERT_EQ(replayed.size(), 1u);
    EXPECT_EQ(replayed[0].entity, expected[0].entity);
    EXPECT_EQ(replayed[0].semantic_class, expected[0].semantic_class);
    EXPECT_EQ(replayed[0].name, expected[0].name);
    EXPECT_EQ(replayed[0].stamp, expected[0].stamp);
    EXPECT_EQ(replayed[0].T_base_entity.R, expected[0].T_base_entity.R);
    EXPECT_EQ(replayed[0].T_base_entity.t, expected[0].T_base_entity.t);
    EXPECT_EQ(replayed[0].covariance, expected[0].covariance);
    EXPECT_EQ(replayed[0].tag_count, 2);
    EXPECT_EQ(replayed[0].sensor_label, "camera");
    EXPECT_EQ(detector->warnings(), original.warnings());
  }
}

TEST_F(FrontEndCacheTest, AnotherRecordingIsNoticed) {
  record(3);
  FrontEndCache cache(file_, "one");
  const auto odometry = cache.wrap(std::make_unique<FailingOdometry>());
  EXPECT_THROW(odometry->update(scan(5), std::nullopt), DataError);
}

TEST_F(FrontEndCacheTest, TheEndOfTheFileIsNoticed) {
  record(1);
  FrontEndCache cache(file_, "one");
  const auto detector = cache.wrap(std::make_unique<NoDetector>());
  const auto odometry = cache.wrap(std::make_unique<FailingOdometry>());
  EXPECT_FALSE(odometry->update(scan(1), std::nullopt));
  EXPECT_EQ(detector->detect(frame(1)).size(), 1u);
  EXPECT_THROW(odometry->update(scan(2), std::nullopt), DataError);
}

TEST_F(FrontEndCacheTest, OtherParametersAndForeignFilesAreRecordedAnew) {
  record(2);
  EXPECT_FALSE(FrontEndCache(file_, "another").replays());
  EXPECT_TRUE(FrontEndCache(file_, "one").replays()) << "not replaced before it is complete";
  std::ofstream(file_) << "something else";
  EXPECT_FALSE(FrontEndCache(file_, "one").replays());
}

TEST_F(FrontEndCacheTest, AnInterruptedRecordingLeavesNothing) {
  record(2, false);
  EXPECT_FALSE(fs::exists(file_));
}

class PlanesInCache : public FrontEndCacheTest {
 protected:
  std::vector<PlaneObservation> extract(const Scan& scan, const std::string& identity = "one") {
    FrontEndCache cache(file_, identity);
    return cache.wrap(std::make_unique<CountingExtractor>(calls_))->extract(scan);
  }
  static Scan scanWith(const Eigen::Vector3f& point) {
    Scan s = scan(5);
    s.cloud.points = {point};
    return s;
  }

  int calls_ = 0;
};

TEST_F(PlanesInCache, AreExtractedOnce) {
  const Scan scan = scanWith({1, 2, 3});
  const auto first = extract(scan), second = extract(scan);
  EXPECT_EQ(calls_, 1);
  ASSERT_EQ(second.size(), 2u);
  EXPECT_EQ(second[1].patch_base.center, first[1].patch_base.center);
  EXPECT_EQ(second[1].patch_base.normal, first[1].patch_base.normal);
  EXPECT_EQ(second[1].patch_base.cells, first[1].patch_base.cells);
  EXPECT_EQ(second[1].covariance, first[1].covariance);
  EXPECT_EQ(second[1].rms_m, first[1].rms_m);
  EXPECT_EQ(second[1].points, first[1].points);
}

TEST_F(PlanesInCache, OfOtherScansAndParametersAreNotTaken) {
  extract(scanWith({1, 2, 3}));
  extract(scanWith({1, 2, 3.001f}));
  EXPECT_EQ(calls_, 2) << "the same time, straightened otherwise";
  extract(scanWith({1, 2, 3}), "another");
  EXPECT_EQ(calls_, 3);
}

TEST_F(PlanesInCache, DamagedFilesAreWrittenAnew) {
  const Scan scan = scanWith({1, 2, 3});
  extract(scan);
  for (const auto& entry : fs::directory_iterator(file_.string() + ".planes"))
    fs::resize_file(entry.path(), fs::file_size(entry.path()) - 1);
  EXPECT_EQ(extract(scan).size(), 2u);
  EXPECT_EQ(calls_, 2);
  extract(scan);
  EXPECT_EQ(calls_, 2);
}

TEST(FrontEndIdentity, ChangesWithTheFrontEndAndNotWithTheSetup) {
  const fs::path rawlog = fs::path(testing::TempDir()) / "some.rawlog";
  std::ofstream(rawlog) << "bytes";
  const DynemoParams params;
  const std::string identity = frontEndIdentity(params, rawlog, std::nullopt);
  DynemoParams setup = params;
  setup.keyframes.timer = !setup.keyframes.timer;
  setup.odometry.noise.jitter_m *= 2;
  EXPECT_EQ(frontEndIdentity(setup, rawlog, std::nullopt), identity);
  DynemoParams front_end = params;
  front_end.odometry.lidar.method = "keyframe_gicp";
  EXPECT_NE(frontEndIdentity(front_end, rawlog, std::nullopt), identity);
  std::ofstream(rawlog) << "more bytes";
  EXPECT_NE(frontEndIdentity(params, rawlog, std::nullopt), identity);
}

}  // namespace
}  // namespace dynemo
