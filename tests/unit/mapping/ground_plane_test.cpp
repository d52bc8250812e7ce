#include "dynemo/mapping/ground_plane.h"

#include <gtest/gtest.h>

namespace dynemo {
namespace {

/// A plane through `center_level`, in the base frame of a robot that is tilted by R_level_base.
PlaneObservation plane(const Vector3& center_level, const Vector3& normal_level,
                       const Matrix3& R_level_base) {
  PlaneObservation p;
  p.patch_base.center = R_level_base.transpose() * center_level;
  p.patch_base.normal = R_level_base.transpose() * normal_level.normalized();
  return p;
}

/// Ground below a levelled base, a wall, a table, the ceiling and a ramp.
std::vector<PlaneObservation> room(double ground_m, const Matrix3& R_level_base) {
  const Vector3 up = Vector3::UnitZ();
  return {plane({4, 0, 1}, -Vector3::UnitX(), R_level_base),
          plane({1, 2, ground_m + 0.7}, up, R_level_base),
          plane({2, -1, ground_m}, up, R_level_base), plane({0, 0, 2}, -up, R_level_base),
          plane({0, 3, ground_m - 1}, Vector3(0, 1, 1), R_level_base)};
}

TEST(FindGround, TakesTheFloorAmongFurnitureAndWalls) {
  const auto ground = findGround(room(-0.9, Matrix3::Identity()), Matrix3::Identity());
  ASSERT_TRUE(ground);
  EXPECT_EQ(ground->observation, 2u);
  EXPECT_NEAR(ground->height_m, -0.9, 1e-12);
}

TEST(FindGround, LevelsATiltedBase) {
  const Matrix3 R_level_base = expSO3(Vector3(0.07, -0.05, 0.3));
  const auto ground = findGround(room(-1.25, R_level_base), R_level_base);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->height_m, -1.25, 1e-12);
}

TEST(FindGround, TheNormalOfATiltedGroundLevelsTheBase) {
  const Matrix3 R_level_base = expSO3(Vector3(0.06, 0.04, 0.0));
  const auto ground = findGround(room(-1.25, R_level_base), Matrix3::Identity());
  ASSERT_TRUE(ground);
  EXPECT_LT(logSO3(levelling(*ground) * R_level_base.transpose()).norm(), 1e-3);
}

TEST(FindGround, ExpectationsTellTheStoreyFromTheOneBelow) {
  auto planes = room(-1.25, Matrix3::Identity());
  planes.push_back(plane({3, 0, -4.25}, Vector3::UnitZ(), Matrix3::Identity()));
  EXPECT_NEAR(findGround(planes, Matrix3::Identity())->height_m, -4.25, 1e-12);
  EXPECT_NEAR(findGround(planes, Matrix3::Identity(), -1.2)->height_m, -1.25, 1e-12);
  EXPECT_FALSE(findGround(planes, Matrix3::Identity(), -2.5));
}

TEST(FindGround, NothingWithoutGround) {
  EXPECT_FALSE(findGround({}, Matrix3::Identity()));
  const auto wall_only = {plane({4, 0, 1}, -Vector3::UnitX(), Matrix3::Identity()),
                          plane({0, 0, 2}, -Vector3::UnitZ(), Matrix3::Identity()),
                          plane({0, 0, 0.5}, Vector3::UnitZ(), Matrix3::Identity())};
  EXPECT_FALSE(findGround(wall_only, Matrix3::Identity()));
}

}  // namespace
}  // namespace dynemo
