#pragma once

#include "dynemo/graph/edge.h"

namespace dynemo {

/// Two entities keep a distance: e = ‖t_b − t_a‖ − distance_m [m] (nodes: entity, entity).
class CEdgeEntityDistance : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgeEntityDistance, dynemo)
 public:
  double distance_m = 0.0;

  int residualSize() const override { return 1; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "entity_distance"; }
  static Ptr example(std::mt19937_64& rng);
};

}  // namespace dynemo
