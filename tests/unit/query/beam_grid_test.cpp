#include "beam_grid.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

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
  return BeamGrid(cloud, std::vector<BeamEnd>(cloud.size(), end))
      .look(p.cast<float>(), SightParams());
}

/// The same without any order of the rays, for a place of another size.
Sight lookAtAll(const PointCloud& cloud, const Vector3& p, double scale) {
  const SightParams params;
  bool through = false, hidden = false;
  for (const Eigen::Vector3f& end : cloud.points) {
    const Vector3 direction = end.cast<double>().normalized();
    const double along = direction.dot(p), beyond = end.cast<double>().norm() - along;
    const double aside = (p - along * direction).norm();
    const bool at_place = std::abs(beyond) <= scale * params.behind_m;
    if (aside <= scale * params.hit_m && at_place) return Sight::kHit;
    if (along < 0.0 || aside > scale * params.ray_radius_m) continue;
    (beyond > scale * params.behind_m ? through : hidden) = true;
  }
  return through && !hidden ? Sight::kThrough : Sight::kNothing;
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

TEST(BeamGrid, FindsTheRaysOfAllDirections) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0), range_m(2.0, 6.0);
  const auto direction = [&]() -> Vector3 {
    for (;;) {
      const Vector3 v(coordinate(rng), coordinate(rng), coordinate(rng));
      if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
    }
  };
  PointCloud cloud;
  for (int i = 0; i < 20'000; ++i)
    cloud.points.push_back((range_m(rng) * direction()).cast<float>());
  const BeamGrid grid(cloud, std::vector<BeamEnd>(cloud.size(), BeamEnd::kThing));
  std::map<Sight, int> seen;
  const auto check = [&](const Vector3& along) {
    // Straight up and down not all azimuths are searched.
    if (std::abs(along.z()) > 0.9) return;
    const Vector3 p = range_m(rng) * along;
    const Sight sight = lookAtAll(cloud, p, 0.999);
    if (sight != lookAtAll(cloud, p, 1.001)) return;  // a matter of rounding
    EXPECT_EQ(grid.look(p.cast<float>(), SightParams()), sight) << p.transpose();
    ++seen[sight];
  };
  for (int i = 0; i < 1000; ++i) check(direction());
  // Where columns end.
  for (int i = 0; i < 300; ++i) {
    const Vector3 aside(0.0, 0.02 * coordinate(rng), 0.02 * coordinate(rng));
    check((-Vector3::UnitX() + aside).normalized());
    check((Vector3::UnitX() + aside).normalized());
  }
  for (const Sight sight : {Sight::kNothing, Sight::kHit, Sight::kThrough})
    EXPECT_GT(seen[sight], 50);
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
