// The part of a plane that was seen.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dynemo/core/plane3.h"

namespace dynemo {

/// Occupied cells of a square grid on a plane: cell (i, j) covers [i, i+1) × [j, j+1) times
/// `cell_m` along the axes B(normal) from `center`, which lies on the plane. Sorted, without
/// duplicates.
struct PlanePatch {
  static constexpr double kCell_m = 0.25;

  Vector3 center = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();
  std::vector<std::array<std::int16_t, 2>> cells;

  double area_m2() const { return kCell_m * kCell_m * static_cast<double>(cells.size()); }
  Plane3 plane() const { return Plane3::through(center, normal); }
};

/// Middles of the cells, carried to another frame by T.
std::vector<Vector3> cellCenters(const PlanePatch& patch, const Pose3& T = Pose3());

/// Whether some point of a and some point of b are no further apart than the gap.
bool withinGap(std::span<const Vector3> a, std::span<const Vector3> b, double gap_m);

/// Takes out the points of a that are no further than the gap from some point of b.
void eraseWithinGap(std::vector<Vector3>& a, std::span<const Vector3> b, double gap_m);

}  // namespace dynemo
