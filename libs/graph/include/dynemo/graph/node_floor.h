#pragma once

#include "dynemo/graph/node.h"

namespace dynemo {

/// A storey: state ξ, the height of its ground over the map's origin [m] (paper, Eq. (8)).
class CNodeFloor : public CNodeBase {
  DEFINE_SERIALIZABLE(CNodeFloor, dynemo)
 public:
  double level_m = 0.0;
  double level_first_m = 0.0;
  /// Where to draw it; not estimated.
  Vector2 center_map_m = Vector2::Zero();

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
