#pragma once

#include <Eigen/Geometry>

#include "dynemo/graph/node.h"

namespace dynemo {

/// A storey: state ξ, the height of its ground over the map's origin [m] (paper, Eq. (8)).
class CNodeFloor : public CNodeBase {
  DEFINE_SERIALIZABLE(CNodeFloor, dynemo)
 public:
  double level_m = 0.0;
  double level_first_m = 0.0;
  /// The middle of its area; not estimated.
  Vector2 center_map_m = Vector2::Zero();
  /// The box around its keyframes and the walls seen from them.
  Eigen::AlignedBox2d area_map_m;
  void extendArea(const Eigen::AlignedBox2d& area) {
    area_map_m.extend(area);
    if (!area_map_m.isEmpty()) center_map_m = area_map_m.center();
  }

  int stateSize() const override { return 1; }
  int tangentSize() const override { return 1; }
  void readState(double* out) const override { *out = level_m; }
  void writeState(const double* state) override { level_m = *state; }
  void retract(const double* state, const double* delta, double* out) const override {
    *out = *state + *delta;
  }
  const char* kind() const override { return "floor"; }
};

}  // namespace dynemo
