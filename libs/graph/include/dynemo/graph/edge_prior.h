#pragma once

#include "dynemo/graph/edge.h"

namespace dynemo {

/// Absolute pose of one pose node: e = T ⊟ T_measured. Fixes the gauge (node: any pose node).
class CEdgePosePrior : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgePosePrior, dynemo)
 public:
  Pose3 T_map_node;

  int residualSize() const override { return 6; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "pose_prior"; }
  static Ptr example(std::mt19937_64& rng);
};

/// Absolute height of a floor: e = ξ − measured [m] (node: floor).
class CEdgeFloorPrior : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgeFloorPrior, dynemo)
 public:
  double level_m = 0.0;

  int residualSize() const override { return 1; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "floor_prior"; }
  static Ptr example(std::mt19937_64& rng);
};

}  // namespace dynemo
