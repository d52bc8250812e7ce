#include "dynemo/graph/plane_patch.h"

#include <algorithm>

namespace dynemo {
namespace {

/// What is no further than a gap from some of the points.
class Neighborhood {
 public:
  Neighborhood(std::span<const Vector3> points, double gap_m) : points_(points), gap_m_(gap_m) {
    for (const Vector3& p : points) center_ += p / static_cast<double>(points.size());
    for (const Vector3& p : points) reach_m_ = std::max(reach_m_, (p - center_).norm());
    reach_m_ += gap_m;
  }
  bool contains(const Vector3& p) const {
    if ((p - center_).norm() > reach_m_) return false;
    return std::any_of(points_.begin(), points_.end(),
                       [&](const Vector3& q) { return (p - q).squaredNorm() <= gap_m_ * gap_m_; });
  }

 private:
  std::span<const Vector3> points_;
  double gap_m_;
  /// A ball around all of it.
  Vector3 center_ = Vector3::Zero();
  double reach_m_ = 0.0;
};

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
  const Neighborhood near_b(b, gap_m);
  return std::any_of(a.begin(), a.end(), [&](const Vector3& p) { return near_b.contains(p); });
}

void eraseWithinGap(std::vector<Vector3>& a, std::span<const Vector3> b, double gap_m) {
  const Neighborhood near_b(b, gap_m);
  std::erase_if(a, [&](const Vector3& p) { return near_b.contains(p); });
}

}  // namespace dynemo
