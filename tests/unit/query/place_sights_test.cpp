// What is said of a place at which more scans could look than do.
#include "place_sights.h"

#include <gtest/gtest.h>

namespace dynemo::test {
namespace {

constexpr int kScans = 400;

/// A robot that goes up and down in front of a place 5 m away, one scan a second.
class PlaceSightsTest : public testing::Test {
 protected:
  PlaceSightsTest() {
    for (int i = 0; i < kScans; ++i) {
      const double y_m = 0.05 * std::abs(i % 80 - 40) - 1.0;
      scans_.push_back({Vector3(0.0, y_m, 0.0), {1'000'000'000LL * i}});
    }
    params_.max_looks = 16;
  }

  /// Rays to the place from a scan; they end there, or 3 m behind it.
  BeamGrid beams(std::size_t scan, bool there) const {
    PointCloud cloud;
    const Vector3 to = place_ - scans_[scan].p_map;
    for (int a = -4; a <= 4; ++a) {
      for (int b = -4; b <= 4; ++b) {
        const Vector3 direction = (to + 0.05 * Vector3(0.0, a, b)).normalized();
        cloud.points.push_back(((to.norm() + (there ? 0.0 : 3.0)) * direction).cast<float>());
      }
    }
    return {cloud, std::vector<BeamEnd>(cloud.size(), BeamEnd::kThing)};
  }

  /// The judgement when the place is occupied as `there` tells; counts the looks of each round.
  template <class There>
  Permanence judge(const There& there) {
    PlaceSights sights({{place_.cast<float>(), Eigen::Vector3f::Zero()}}, scans_, params_,
                       SightParams(), PlaceSights::AlongSurface::kHits);
    looks_.clear();
    do {
      looks_.push_back(0);
      for (std::size_t i = 0; i < scans_.size(); ++i) {
        if (!sights.looks(i)) continue;
        ++looks_.back();
        sights.look(i, beams(i, there(static_cast<int>(i))), Pose3::translation(scans_[i].p_map));
      }
    } while (sights.lookCloser());
    return sights.at(0);
  }

  const Vector3 place_{5.0, 0.0, 0.0};
  std::vector<Viewpoint> scans_;
  StructureParams params_;
  std::vector<int> looks_;
};

TEST_F(PlaceSightsTest, OneRoundTellsWhatLastsAndWhatPasses) {
  EXPECT_EQ(judge([](int) { return true; }), Permanence::kLasting);
  EXPECT_EQ(looks_, std::vector<int>{16});
  EXPECT_EQ(judge([](int i) { return i / 10 == 7; }), Permanence::kPassing);
  EXPECT_EQ(looks_, std::vector<int>{16});
}

TEST_F(PlaceSightsTest, ASecondRoundTellsWhatIsGoneInTheEnd) {
  const auto there = [](int i) { return i < 370; };
  EXPECT_EQ(judge(there), Permanence::kPassing);
  EXPECT_EQ(looks_, (std::vector<int>{16, 16 * PlaceSights::kCloser}));
  // What came back is there.
  EXPECT_EQ(judge([](int i) { return i < 200 || i >= 300; }), Permanence::kLasting);
}

TEST_F(PlaceSightsTest, AReturnAlongTheSurfaceCountsWhereAskedFor) {
  for (const auto along : {PlaceSights::AlongSurface::kHits, PlaceSights::AlongSurface::kNothing}) {
    PlaceSights sights({{place_.cast<float>(), Eigen::Vector3f::UnitY()}}, scans_, params_,
                       SightParams(), along);
    for (std::size_t i = 0; i < scans_.size(); ++i)
      if (sights.looks(i)) sights.look(i, beams(i, true), Pose3::translation(scans_[i].p_map));
    EXPECT_EQ(sights.at(0), along == PlaceSights::AlongSurface::kHits ? Permanence::kLasting
                                                                      : Permanence::kUnknown);
  }
}

}  // namespace
}  // namespace dynemo::test
