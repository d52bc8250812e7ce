#include "dynemo/query/sightlines.h"

#include <gtest/gtest.h>

#include "rooms.h"

namespace dynemo::test {
namespace {

const Extent kBox{Vector3::Constant(-0.25), Vector3::Constant(0.25)};
const Vector3 kPlace(3.0, 0.0, 0.0);

RayCount raysAt(const std::vector<Vector3>& boxes, const Vector3& place = kPlace) {
  SessionBuilder builder;
  builder.scan(0.0, boxes);
  const auto& scan = *builder.session.graph.keyframes().back()->scan;
  return countRays(scan.cloud, Pose3::translation(place).inverse(), kBox);
}

TEST(Sightlines, EndOnABoxThatIsThere) {
  const RayCount rays = raysAt({kPlace});
  EXPECT_GT(rays.hits, 10);
  EXPECT_EQ(rays.through, 0);
}

TEST(Sightlines, GoThroughAnEmptyPlace) {
  const RayCount rays = raysAt({});
  EXPECT_GT(rays.through, 10);
  EXPECT_EQ(rays.hits, 0);
}

TEST(Sightlines, SayNothingOfAHiddenPlace) {
  const RayCount rays = raysAt({Vector3(1.5, 0.0, 0.0)});
  EXPECT_EQ(rays.hits + rays.through, 0);
}

TEST(Sightlines, SayNothingOfAPlaceOutOfView) {
  const RayCount rays = raysAt({}, Vector3(-3.0, 0.0, 0.0));
  EXPECT_EQ(rays.hits + rays.through, 0);
}

TEST(Sightlines, WeighEvidence) {
  const QueryParams params;
  EXPECT_FALSE(likelihoodRatio({params.min_rays - 1, 0}, params));
  EXPECT_FALSE(likelihoodRatio({20, 20}, params));
  EXPECT_GT(likelihoodRatio({40, 1}, params).value(), 1.0);
  EXPECT_LT(likelihoodRatio({1, 40}, params).value(), 1.0);
}

TEST(Sightlines, AreTakenBetweenTheTimesOnly) {
  SessionBuilder builder;
  for (const double t : {0.0, 1.0, 2.0, 3.0}) builder.scan(t, {});
  const auto looks = looksAt(builder.session.graph, Pose3::translation(kPlace), kBox, at(0.0),
                             at(3.0), QueryParams());
  ASSERT_EQ(looks.size(), 2u);
  EXPECT_DOUBLE_EQ(looks[0].after_s, 1.0);
  EXPECT_DOUBLE_EQ(looks[1].after_s, 2.0);
  EXPECT_LT(looks[0].likelihood_ratio, 1.0);
}

}  // namespace
}  // namespace dynemo::test
