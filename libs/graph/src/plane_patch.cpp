#include "dynemo/graph/plane_patch.h"

namespace dynemo {
namespace {

struct Ball {
  Vector3 center = Vector3::Zero();
  double radius_m = 0.0;
};

Ball ballAround(std::span<const Vector3> points) {
  Ball ball;
  for (const Vector3& p : points) ball.center += p / static_cast<double>(points.size());
  for (const Vector3& p : points) ball.radius_m = std::max(ball.radius_m, (p - ball.center).norm());
  return ball;
}

}  // namespace

std::vector<Vector3> cellCenters(const PlanePatch& patch, const Pose3& T) {
  const Eigen::Matrix<double, 3, 2> axes =
      PlanePatch::kCell_m * (T.R * orthogonalBasis(patch.normal));
  const Vector3 center = T * patch.center;
  std::vector<Vector3> points;
  points.reserve(patch.cells.size());
  for (const auto& cell : patch.cells)
    points.push_back(center + axes * Vector2(cell[0] + 0.5, cell[1] + 0.5));
  return points;
}

bool withinGap(std::span<const Vector3> a, std::span<const Vector3> b, double gap_m) {
  if (a.empty() || b.empty()) return false;
  const Ball ball_b = ballAround(b);
  const double reach_m = ball_b.radius_m + gap_m, gap_m2 = gap_m * gap_m;
  for (const Vector3& p : a) {
    if ((p - ball_b.center).norm() > reach_m) continue;
    for (const Vector3& q : b) {
      if ((p - q).squaredNorm() <= gap_m2) return true;
    }
  }
  return false;
}

}  // namespace dynemo
