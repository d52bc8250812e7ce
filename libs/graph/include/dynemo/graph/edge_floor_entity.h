#pragma once

#include "dynemo/graph/edge.h"

namespace dynemo {

/// An entity keeps its height over its floor: e = ξ − (ε)_z − z̃ [m] (paper, Eq. (12); nodes: floor,
/// entity).
class CEdgeFloorEntity : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgeFloorEntity, dynemo)
 public:
  /// z̃: floor level minus the entity's height, at its first observation on the floor [m].
  double offset_m = 0.0;

  int residualSize() const override { return 1; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "floor_entity"; }
  static Ptr example(std::mt19937_64& rng);
};

}  // namespace dynemo
