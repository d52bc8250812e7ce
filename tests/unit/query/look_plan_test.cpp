#include "look_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace dynemo::test {
namespace {

Viewpoint view(double x_m, double seconds) {
  return {Vector3(x_m, 0.0, 0.0), {static_cast<std::int64_t>(seconds * 1e9)}};
}

TEST(SpreadViewpoints, AreAllThatAreNearWhileTheyAreFew) {
  std::vector<Viewpoint> views;
  for (int i = 0; i < 10; ++i) views.push_back(view(i, i));
  EXPECT_EQ(spreadViewpoints(views, Vector3::Zero(), 4.5, 5),
            (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
  EXPECT_TRUE(spreadViewpoints(views, {0.0, 20.0, 0.0}, 4.5, 5).empty());
  EXPECT_TRUE(spreadViewpoints({}, Vector3::Zero(), 4.5, 5).empty());
}

TEST(SpreadViewpoints, AreSpreadEvenlyOverTheTimeOfARobotThatWaits) {
  std::vector<Viewpoint> views;
  for (int i = 0; i <= 1024; ++i) views.push_back(view(0.0, i));
  const auto chosen = spreadViewpoints(views, Vector3::Zero(), 15.0, 17);
  ASSERT_EQ(chosen.size(), 17u);
  for (std::uint32_t i = 0; i < 17; ++i) EXPECT_NEAR(chosen[i], 64.0 * i, 1.0);
}

TEST(SpreadViewpoints, AreTakenRarelyFromWhereTheRobotWaitedLong) {
  // 50 scans on the way, 500 more in one place while it takes ten seconds.
  std::vector<Viewpoint> views;
  for (int i = 0; i < 25; ++i) views.push_back(view(0.5 * i, i));
  for (int i = 0; i < 500; ++i) views.push_back(view(12.5, 25.0 + 0.02 * i));
  for (int i = 0; i < 25; ++i) views.push_back(view(12.5 - 0.5 * i, 36 + i));
  const auto chosen = spreadViewpoints(views, {6.0, 3.0, 0.0}, 15.0, 32);
  ASSERT_EQ(chosen.size(), 32u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  EXPECT_EQ(chosen.back(), views.size() - 1);
  const auto waiting = std::count_if(chosen.begin(), chosen.end(),
                                     [](std::uint32_t i) { return i >= 25 && i < 525; });
  EXPECT_GE(waiting, 2);
  EXPECT_LE(waiting, 8);
}

TEST(SpreadViewpoints, EndWhenAllThatIsLeftIsTheSame) {
  const std::vector<Viewpoint> views(20, view(1.0, 5.0));
  EXPECT_EQ(spreadViewpoints(views, Vector3::Zero(), 15.0, 4).size(), 1u);
}

TEST(LookPlan, HasEachPlaceLookedAtByABoundedNumberOfScansInReach) {
  std::vector<SeenPlace> places;
  for (int i = 0; i < 400; ++i)
    places.push_back({{0.5f * static_cast<float>(i % 100), static_cast<float>(i / 100), 1.0f},
                      Eigen::Vector3f::Zero()});
  std::vector<Viewpoint> scans;
  for (int i = 0; i < 200; ++i) scans.push_back(view(0.25 * i, i));
  std::vector<std::uint32_t> even;
  for (std::uint32_t i = 0; i < 400; i += 2) even.push_back(i);
  const LookPlan plan(places, even, scans, 15.0, 20);
  std::map<std::uint32_t, int> looks;
  for (std::size_t scan = 0; scan < scans.size(); ++scan) {
    bool any = false;
    plan.forEachPlace(scan, [&](std::uint32_t i) {
      ++looks[i];
      any = true;
      EXPECT_LT((places[i].middle.cast<double>() - scans[scan].p_map).norm(), 15.0 + 3.2 * 1.8);
    });
    EXPECT_EQ(plan.looks(scan), any);
  }
  EXPECT_EQ(looks.size(), even.size());
  for (const auto& [place, count] : looks) {
    EXPECT_EQ(place % 2, 0u);
    EXPECT_EQ(count, 20);
  }
}

}  // namespace
}  // namespace dynemo::test
