#include "dynemo/loops/closure_set.h"

#include <gtest/gtest.h>

#include "loop_graph.h"

namespace dynemo {
namespace {

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
  std::vector<bool> consistent() const { return set_.consistent(); }

  test::LoopGraph drive_;
  OdometryChain chain_;
  ConsistencyParams params_;
  ClosureSet set_{params_};
};

TEST_F(ClosureSets, RightClosuresAgree) {
  EXPECT_EQ(compare(closure(2), closure(4), chain_, params_), Agreement::kAgree);
  EXPECT_EQ(compare(closure(4), closure(2), chain_, params_), Agreement::kAgree);
}

TEST_F(ClosureSets, AWrongOneContradictsItsNeighbours) {
  EXPECT_EQ(compare(closure(2, 1.0), closure(4), chain_, params_), Agreement::kContradict);
  EXPECT_EQ(compare(closure(4), closure(2, 1.0), chain_, params_), Agreement::kContradict);
}

TEST_F(ClosureSets, UncertainOdometrySaysNothing) {
  params_.max_chain_sigma_m = 0.03;
  EXPECT_EQ(compare(closure(2, 1.0), closure(12), chain_, params_), Agreement::kSilent);
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

}  // namespace
}  // namespace dynemo
