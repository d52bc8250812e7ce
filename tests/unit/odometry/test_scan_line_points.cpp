#include <gtest/gtest.h>

#include <cmath>

#include "dynemo/odometry/scan_line_points.h"

namespace dynemo {
namespace {

/// The plane z = a x + b y.
Eigen::Vector3f onPlane(float x, float y) { return {x, y, 0.2F * x - 0.1F * y}; }
const Eigen::Vector3f kNormal = Eigen::Vector3f(-0.2F, 0.1F, 1.0F).normalized();

constexpr float kElevation_rad = -0.2F;

/// Adds points along y, of a sweep of its own, at the given x; the last answer.
template <class Surface>
std::optional<Eigen::Vector3f> addLine(ScanLinePoints& lines, float x, const Surface& surface) {
  lines.beginSweep();
  std::optional<Eigen::Vector3f> normal;
  for (int i = -10; i <= 10; ++i)
    normal = lines.add(surface(x, 0.1F * static_cast<float>(i)), kElevation_rad);
  return normal;
}

TEST(ScanLinePoints, OneOrTwoLinesTellNothing) {
  ScanLinePoints lines;
  EXPECT_FALSE(addLine(lines, 0.0F, onPlane));
  EXPECT_FALSE(addLine(lines, 0.3F, onPlane));
}

TEST(ScanLinePoints, ThreeLinesShowThePlane) {
  ScanLinePoints lines;
  addLine(lines, -0.2F, onPlane);
  addLine(lines, 0.2F, onPlane);
  const auto normal = addLine(lines, 0.0F, onPlane);
  ASSERT_TRUE(normal);
  EXPECT_GT(std::abs(normal->dot(kNormal)), 0.999F);
}

TEST(ScanLinePoints, LinesAroundACornerShowNoSurface) {
  const auto corner = [](float x, float y) {
    return x < 0.0F ? Eigen::Vector3f(0.0F, y, -x) : Eigen::Vector3f(x, y, 0.0F);
  };
  ScanLinePoints lines;
  addLine(lines, -0.25F, corner);
  addLine(lines, 0.25F, corner);
  EXPECT_FALSE(addLine(lines, 0.0F, corner));
}

/// As a ring of the sensor lies on the walls, the floor and the ceiling of a corridor.
TEST(ScanLinePoints, ALineAroundACornerIsOneLine) {
  ScanLinePoints lines;
  lines.beginSweep();
  for (int i = 0; i <= 10; ++i) {
    const float s = 0.1F * static_cast<float>(i);
    EXPECT_FALSE(lines.add({5.0F, s, 0.0F}, kElevation_rad));
    EXPECT_FALSE(lines.add({5.0F, 0.0F, s}, kElevation_rad));
  }
}

TEST(ScanLinePoints, LinesOfOneSweepAreToldApartByTheirElevation) {
  ScanLinePoints lines;
  lines.beginSweep();
  std::optional<Eigen::Vector3f> normal;
  for (int line = -1; line <= 1; ++line)
    for (int i = -10; i <= 10; ++i)
      normal = lines.add(onPlane(0.3F * static_cast<float>(line), 0.1F * static_cast<float>(i)),
                         kElevation_rad + 0.03F * static_cast<float>(line));
  EXPECT_TRUE(normal);
}

/// Two of three lines are so near each other that they are as good as one.
TEST(ScanLinePoints, TheLinesMustCoverAnArea) {
  ScanLinePoints lines;
  addLine(lines, -0.45F, onPlane);
  addLine(lines, 0.5F, onPlane);
  EXPECT_FALSE(addLine(lines, 0.38F, onPlane));
}

TEST(ScanLinePoints, TheSameLineAgainAndAgainTellsNothing) {
  ScanLinePoints lines;
  for (int n = 0; n < 20; ++n) EXPECT_FALSE(addLine(lines, 0.0F, onPlane));
}

TEST(ScanLinePoints, WhatIsFarIsForgotten) {
  ScanLinePoints lines;
  addLine(lines, -0.2F, onPlane);
  addLine(lines, 0.2F, onPlane);
  lines.removeFartherThan(Eigen::Vector3f(100.0F, 0.0F, 0.0F), 50.0);
  EXPECT_FALSE(addLine(lines, 0.0F, onPlane));
}

}  // namespace
}  // namespace dynemo
