#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <sstream>

#include "dynemo/core/error.h"
#include "sample_dataset.h"
#include "tagslam_dataset.h"

namespace dynemo {
namespace {

constexpr double kPosition_m = 0.01;
constexpr double kRotation_rad = std::numbers::pi / 180.0;
constexpr EntityId kBody{1};

class Tagslam : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = test::realDataFolder();
    if (!folder) GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
    folder_ = *folder / "tagslam";
  }
  std::filesystem::path folder_;
};

/// The body's pose in the rig's frame, as one camera sees it.
Expected<ResolvedPose, TagPoseFailure> seeBody(const test::TagslamDataset& dataset,
                                               const test::TagslamFrame& frame) {
  const auto solution = solveEntityPose(dataset.bodyAsEntity(kBody),
                                        dataset.cameras[frame.camera].model, frame.tags, {});
  if (!solution) return make_unexpected(solution.error());
  return resolveAmbiguity(*solution, {}, {});
}

TEST_F(Tagslam, Test15FindsTheMovingCubeWhereTheReferenceLastHasIt) {
  const auto dataset = test::readTagslam(folder_ / "test_15");
  const auto& [last_stamp, T_rig_cube] = *dataset.reference_tracks.at("cube").rbegin();
  int seen = 0;
  for (const test::TagslamFrame& frame : dataset.frames) {
    if (frame.stamp != last_stamp) continue;
    const auto body = seeBody(dataset, frame);
    ASSERT_TRUE(body) << text(body.error());
    const Vector6 error =
        local(T_rig_cube, dataset.cameras[frame.camera].T_rig_camera * body->pose.T_camera_entity);
    EXPECT_LT(error.head<3>().norm(), kPosition_m) << dataset.cameras[frame.camera].name;
    EXPECT_LT(error.tail<3>().norm(), kRotation_rad) << dataset.cameras[frame.camera].name;
    ++seen;
  }
  EXPECT_EQ(seen, 2);
}

TEST_F(Tagslam, Test15BothCamerasAgreeAllTheTime) {
  const auto dataset = test::readTagslam(folder_ / "test_15");
  std::map<Stamp, std::vector<Pose3>> poses;
  for (const test::TagslamFrame& frame : dataset.frames) {
    if (const auto body = seeBody(dataset, frame)) {
      poses[frame.stamp].push_back(dataset.cameras[frame.camera].T_rig_camera *
                                   body->pose.T_camera_entity);
    }
  }
  std::vector<double> differences;
  for (const auto& [stamp, pair] : poses) {
    if (pair.size() == 2) differences.push_back((pair[0].t - pair[1].t).norm());
  }
  ASSERT_GT(differences.size(), 100U);
  std::sort(differences.begin(), differences.end());
  EXPECT_LT(differences[differences.size() / 2], kPosition_m);
}

TEST_F(Tagslam, Test23FollowsTheMovingBoard) {
  const auto dataset = test::readTagslam(folder_ / "test_23");
  const auto& reference = dataset.reference_tracks.at("tag_board");
  const Pose3 T_map_rig = dataset.reference_last.at("rig");
  std::size_t compared = 0, unsolved = 0;
  double sum = 0.0;
  for (const test::TagslamFrame& frame : dataset.frames) {
    const auto expected = reference.find(frame.stamp);
    if (expected == reference.end()) continue;
    const auto body = seeBody(dataset, frame);
    if (!body) {
      ++unsolved;
      continue;
    }
    const Pose3 T_map_board =
        T_map_rig * dataset.cameras[frame.camera].T_rig_camera * body->pose.T_camera_entity;
    sum += (T_map_board.t - expected->second.t).squaredNorm();
    ++compared;
  }
  ASSERT_GT(compared, 350U);
  EXPECT_LT(unsolved, compared / 20);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(compared)), kPosition_m);
}

TEST_F(Tagslam, Tests16And17BecomeDetectionsOfOneEntityPerTag) {
  for (const auto& [name, tags] : {std::pair("test_16", 5U), std::pair("test_17", 3U)}) {
    const auto dataset = test::readTagslam(folder_ / name);
    const EntityModels models = dataset.tagsAsEntities();
    EXPECT_EQ(models.all().size(), tags);
    std::ostringstream csv;
    AmbiguityParams ambiguity;
    ambiguity.fallback = AmbiguityParams::Fallback::kInflate;
    test::writeDetections(dataset, models, {}, ambiguity, csv);
    std::istringstream lines(csv.str());
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      EXPECT_EQ(std::count(line.begin(), line.end(), ','), 31) << line;
    }
    std::size_t observed = 0;
    for (const auto& frame : dataset.frames) observed += frame.tags.size();
    EXPECT_GT(count, observed * 95 / 100) << name;
  }
}

TEST_F(Tagslam, AMissingFolderIsADataError) {
  EXPECT_THROW(test::readTagslam(folder_ / "test_999"), DataError);
}

}  // namespace
}  // namespace dynemo
