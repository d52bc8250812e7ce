#include "dynemo/loops/closure_set.h"

#include <gtest/gtest.h>

#include "loop_graph.h"

namespace dynemo {
namespace {

const double kContradiction = chiSquaredQuantile(6, 0.999);

class ClosureSets : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 2 * 24; ++i) drive_.addKeyframe();
    chain_.extend(drive_.graph);
  }
  Closure closure(std::size_t earlier, double error_m = 0.0) const {
    const std::size_t later = earlier + 24;
    return {earlier,
            later,
            {drive_.trueRelative(earlier, later) * Pose3::translation(error_m, 0, 0),
             isotropicCovariance(0.01, 0.002)}};
  }
  std::optional<LoopCheck> check(const Closure& a, const Closure& b) const {
    return checkLoop(a, b, chain_, params_.max_chain_sigma_m);
  }
  std::vector<bool> consistent() const { return set_.consistent(); }

  test::LoopGraph drive_;
  OdometryChain chain_;
  ConsistencyParams params_;
  ClosureSet set_{params_};
};

TEST_F(ClosureSets, ALoopOfRightClosuresIsTheIdentityEitherWayRound) {
  const auto ab = check(closure(2), closure(4)), ba = check(closure(4), closure(2));
  ASSERT_TRUE(ab && ba);
  EXPECT_LT(ab->squared_distance[0], kContradiction);
  EXPECT_NEAR(ab->squared_distance[0], ba->squared_distance[0], 0.05 * ab->squared_distance[0]);
}

TEST_F(ClosureSets, AWrongOneContradictsItsNeighbours) {
  EXPECT_GT(check(closure(2, 1.0), closure(4))->squared_distance[0], kContradiction);
  EXPECT_GT(check(closure(4), closure(2, 1.0))->squared_distance[0], kContradiction);
}

TEST_F(ClosureSets, UncertainOdometrySaysNothing) {
  EXPECT_FALSE(checkLoop(closure(2, 1.0), closure(12), chain_, 0.03));
}

TEST_F(ClosureSets, LearnsHowMuchWorseTheOdometryIsThanItSays) {
  for (const double worse : {1.0, 2.0}) {
    test::LoopGraphParams params;
    params.sigma_m *= worse;
    params.sigma_rad *= worse;
    params.claimed_scale = 1.0 / worse;
    test::LoopGraph drive(params);
    for (int i = 0; i < 2 * 24; ++i) drive.addKeyframe();
    OdometryChain chain;
    chain.extend(drive.graph);
    ClosureSet set{params_};
    EXPECT_EQ(set.driftScale(), params_.max_drift_scale);
    for (std::size_t k = 0; k < 24; ++k)
      set.add({k, k + 24, {drive.trueRelative(k, k + 24), isotropicCovariance(0.01, 0.002)}},
              chain);
    EXPECT_GE(set.driftScale(), 0.75 * worse);
    EXPECT_LE(set.driftScale(), 1.4 * worse);
  }
}

TEST_F(ClosureSets, TheMajorityStays) {
  for (const std::size_t k : {1, 2, 3, 4}) set_.add(closure(k, k == 2 ? 1.0 : 0.0), chain_);
  EXPECT_EQ(consistent(), (std::vector<bool>{true, false, true, true}));
}

TEST_F(ClosureSets, OfTwoTheOlderStaysUntilAThirdDecides) {
  set_.add(closure(1, 1.0), chain_);
  set_.add(closure(2), chain_);
  EXPECT_EQ(consistent(), (std::vector<bool>{true, false}));
  set_.add(closure(3), chain_);
  EXPECT_EQ(consistent(), (std::vector<bool>{false, true, true}));
}

TEST_F(ClosureSets, DiscardedOnesHaveNoSay) {
  const std::size_t wrong = set_.add(closure(1, 1.0), chain_);
  set_.discard(wrong);
  set_.add(closure(2), chain_);
  EXPECT_EQ(consistent(), (std::vector<bool>{false, true}));
}

TEST_F(ClosureSets, AKeyframeThatLeavesTakesItsClosuresAlong) {
  for (const std::size_t k : {1, 2, 3, 4}) set_.add(closure(k, k == 3 ? 1.0 : 0.0), chain_);
  chain_.remove(2);
  EXPECT_EQ(set_.removeKeyframe(2), (std::vector<bool>{true, false, true, true}));
  ASSERT_EQ(set_.size(), 3u);
  EXPECT_EQ(set_[0].earlier, 1u);
  EXPECT_EQ(set_[1].earlier, 2u);
  EXPECT_EQ(set_[1].later, 26u);
  // The others are held against each other as before, and against those that come.
  EXPECT_EQ(consistent(), (std::vector<bool>{true, false, true}));
  Closure next = closure(6);
  --next.earlier;
  --next.later;
  set_.add(next, chain_);
  EXPECT_EQ(consistent(), (std::vector<bool>{true, false, true, true}));
}

}  // namespace
}  // namespace dynemo
