#include "beam_grid.h"

#include <gtest/gtest.h>

namespace dynemo::test {
namespace {

/// Rays about the x axis, half a degree apart, that end at the given distance along it.
PointCloud fan(double end_m) {
  PointCloud cloud;
  for (int a = -10; a <= 10; ++a) {
    for (int b = -10; b <= 10; ++b)
      cloud.points.push_back(Vector3(end_m, 0.0087 * a * end_m, 0.0087 * b * end_m).cast<float>());
  }
  return cloud;
}

Sight look(const PointCloud& cloud, const Vector3& p, BeamEnd end = BeamEnd::kThing) {
  return BeamGrid(cloud, std::vector<BeamEnd>(cloud.size(), end)).look(p, SightParams());
}

TEST(BeamGrid, SeesThroughWhatRaysPass) {
  EXPECT_EQ(look(fan(5.0), {3.0, 0.0, 0.0}), Sight::kThrough);
  EXPECT_EQ(look(fan(3.0), {3.0, 0.0, 0.0}), Sight::kHit);
  EXPECT_EQ(look(fan(3.1), {3.0, 0.0, 0.0}), Sight::kHit);
  EXPECT_EQ(look(fan(2.0), {3.0, 0.0, 0.0}), Sight::kNothing);
  EXPECT_EQ(look(fan(5.0), {3.0, 1.5, 0.0}), Sight::kNothing);
  EXPECT_EQ(look(fan(5.0), {-3.0, 0.0, 0.0}), Sight::kNothing);
}

TEST(BeamGrid, TheSeamOfTheAzimuthIsNoEdge) {
  PointCloud behind = fan(5.0);
  for (auto& p : behind.points) p.x() = -p.x();
  for (const double y : {-0.02, 0.0, 0.02})
    EXPECT_EQ(look(behind, {-3.0, y, 0.0}), Sight::kThrough);
}

TEST(BeamGrid, OneReturnAtThePlaceCountsMoreThanRaysBeside) {
  PointCloud cloud = fan(5.0);
  cloud.points.emplace_back(3.0f, 0.08f, 0.0f);
  EXPECT_EQ(look(cloud, {3.0, 0.0, 0.0}), Sight::kHit);
}

TEST(BeamGrid, AnEntityHidesAndIsNoHit) {
  EXPECT_EQ(look(fan(3.0), {3.0, 0.0, 0.0}, BeamEnd::kEntity), Sight::kNothing);
  EXPECT_EQ(look(fan(5.0), {3.0, 0.0, 0.0}, BeamEnd::kEntity), Sight::kThrough);
}

TEST(BeamGrid, TheFloorIsNotWhatStandsOnIt) {
  EXPECT_EQ(look(fan(3.05), {3.0, 0.0, 0.0}, BeamEnd::kFloor), Sight::kNothing);
  EXPECT_EQ(look(fan(5.0), {3.0, 0.0, 0.0}, BeamEnd::kFloor), Sight::kThrough);
}

TEST(BeamGrid, AnEmptyScanSaysNothing) {
  EXPECT_EQ(look(PointCloud(), {3.0, 0.0, 0.0}), Sight::kNothing);
  EXPECT_EQ(look(fan(5.0), Vector3::Zero()), Sight::kNothing);
}

}  // namespace
}  // namespace dynemo::test
