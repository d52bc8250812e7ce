#include "dynemo/loops/candidate_search.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "loop_graph.h"

namespace dynemo {
namespace {

/// One keyframe per metre of a 24 m lap.
class CandidateSearches : public testing::Test {
 protected:
  void drive(int keyframes, const test::LoopGraphParams& params = {}) {
    drive_ = std::make_unique<test::LoopGraph>(params);
    for (int i = 0; i < keyframes; ++i) drive_->addKeyframe();
  }
  std::vector<LoopCandidate> search(std::optional<std::size_t> last_closure = {}) {
    chain_.extend(drive_->graph);
    return CandidateSearch(params_, entities_)
        .search(drive_->graph, chain_, last_closure, drive_->optimizer);
  }
  static std::vector<std::size_t> earlier(const std::vector<LoopCandidate>& candidates) {
    std::vector<std::size_t> list;
    for (const LoopCandidate& c : candidates) list.push_back(c.earlier);
    return list;
  }
  bool found(const std::vector<LoopCandidate>& candidates, std::size_t k) {
    const auto list = earlier(candidates);
    return std::find(list.begin(), list.end(), k) != list.end();
  }

  CandidateParams params_;
  EntityEvidenceParams entities_;
  std::unique_ptr<test::LoopGraph> drive_;
  OdometryChain chain_;
};

TEST_F(CandidateSearches, FindTheSamePlaceALapLaterNearestFirst) {
  drive(24 + 4);
  params_.separation_m = 0.0;
  const auto candidates = search();
  ASSERT_EQ(candidates.size(), 3u);
  EXPECT_EQ(candidates.front().earlier, 3u);
  EXPECT_EQ(candidates.front().later, 27u);
  EXPECT_EQ(candidates.front().origin, LoopOrigin::kDistance);
  EXPECT_NEAR(candidates.front().path_m, 24.0, 1.0);
  EXPECT_TRUE(std::is_sorted(candidates.begin(), candidates.end(),
                             [](auto& a, auto& b) { return a.distance_m < b.distance_m; }));
}

TEST_F(CandidateSearches, KeepOutWhatIsFarOrJustBehind) {
  drive(12);
  EXPECT_TRUE(search().empty());  // only the last few metres are near
  drive(24 + 4);
  params_.min_path_m = 25.0;
  chain_ = {};
  EXPECT_TRUE(search().empty());
}

TEST_F(CandidateSearches, CandidatesOfOneKeyframeAreApart) {
  drive(2 * 24 + 4);
  params_.separation_m = 4.0;
  const auto candidates = search();
  ASSERT_EQ(candidates.size(), 2u);  // one of each lap
  EXPECT_TRUE(found(candidates, 3) && found(candidates, 27));
}

TEST_F(CandidateSearches, KeepTheirDistanceFromTheLastClosure) {
  drive(24 + 6);
  params_.spacing_m = 5.0;
  EXPECT_TRUE(search(27).empty());
  EXPECT_FALSE(search(22).empty());
  params_.spacing_m = 0.0;
  params_.spacing_s = 10.0;
  EXPECT_TRUE(search(22).empty());
  EXPECT_FALSE(search(18).empty());
}

TEST_F(CandidateSearches, StayOnOneFloor) {
  drive(24 + 4);
  for (const auto& keyframe : drive_->graph.keyframes())
    keyframe->floor = NodeId{keyframe->id.value < 20 ? 1000u : 1001u};
  EXPECT_TRUE(search().empty());
  for (const auto& keyframe : drive_->graph.keyframes()) keyframe->floor.reset();
  EXPECT_FALSE(search().empty());
}

TEST_F(CandidateSearches, KeepStoreysApartBeforeTheirFloorsAreKnown) {
  drive(24 + 4);
  drive_->graph.keyframes().back()->T_map_node.t.z() += 3.0;
  EXPECT_TRUE(search().empty());
}

TEST_F(CandidateSearches, NeedBothScans) {
  drive(24 + 4);
  drive_->graph.keyframes().back()->scan.reset();
  EXPECT_TRUE(search().empty());
}

TEST_F(CandidateSearches, UncertaintyWidensTheGate) {
  test::LoopGraphParams loose;
  loose.sigma_m = 0.1;
  drive(24 + 4, loose);
  params_.max_distance_m = 1e-3;
  ASSERT_TRUE(search().empty());
  params_.gate = CandidateGate::kUncertainty;
  params_.uncertainty_sigmas = 3.0;
  const auto candidates = search();
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates.front().origin, LoopOrigin::kUncertainty);
  params_.max_uncertain_distance_m = 1e-3;
  EXPECT_TRUE(search().empty());
}

class FromEntities : public CandidateSearches {
 protected:
  /// Two laps, on both of which the same objects are seen from keyframe 3; the last keyframe has
  /// drifted away from everything.
  void driveWithObjects(int objects) {
    drive(0);
    for (std::size_t k = 0; k < 24 + 4; ++k) {
      drive_->addKeyframe();
      if (k % 24 != 3) continue;
      for (int i = 0; i < objects; ++i)
        drive_->see({i + 1}, Pose3::translation(5.0 + i, 1.0 - i, 0.3));
    }
    drive_->graph.keyframes().back()->T_map_node.t.x() += 50.0;
  }
};

TEST_F(FromEntities, ObjectsSeenAgainMakeACandidateWhereTheEstimateIsFarOff) {
  driveWithObjects(2);
  const auto candidates = search();
  ASSERT_EQ(candidates.size(), 1u);
  EXPECT_EQ(candidates[0].earlier, 3u);
  EXPECT_EQ(candidates[0].origin, LoopOrigin::kEntities);
  EXPECT_GT(candidates[0].distance_m, params_.max_distance_m);
}

TEST_F(FromEntities, OneObjectMayHaveMoved) {
  driveWithObjects(1);
  EXPECT_TRUE(search().empty());
  entities_.min_shared = 1;
  EXPECT_FALSE(search().empty());
}

TEST_F(FromEntities, CanBeTurnedOff) {
  driveWithObjects(2);
  entities_.candidates = false;
  EXPECT_TRUE(search().empty());
}

}  // namespace
}  // namespace dynemo
