// Motion constraints on agents that add information of their own, instead of repeating the relative
// pose of the two detections they connect.
#pragma once

#include "dynemo/graph/edge.h"

namespace dynemo {

/// An agent walks along u: its displacement has no component orthogonal to u (nodes: entity,
/// entity).
///   e = B(u)ᵀ R_1ᵀ (t_2 − t_1) ∈ R² [m], B(u) an orthonormal basis of the plane orthogonal to u.
class CEdgeAgentLine : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgeAgentLine, dynemo)
 public:
  /// Unit vector u in the frame of the first entity node.
  Vector3 direction_entity = Vector3::UnitX();

  int residualSize() const override { return 2; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "agent_line"; }
  static Ptr example(std::mt19937_64& rng);
};

/// An agent keeps its velocity over three observations (nodes: entity, entity, entity).
///   e = (t_3 − t_2)/Δt_23 − (t_2 − t_1)/Δt_12 ∈ R³ [m/s], in the map frame.
class CEdgeAgentVelocity : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgeAgentVelocity, dynemo)
 public:
  double dt_12_s = 1.0, dt_23_s = 1.0;

  int residualSize() const override { return 3; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "agent_velocity"; }
  static Ptr example(std::mt19937_64& rng);
};

}  // namespace dynemo
