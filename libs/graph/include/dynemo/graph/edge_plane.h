// Edges to and between planes.
#pragma once

#include "dynemo/graph/edge.h"
#include "dynemo/graph/plane_patch.h"

namespace dynemo {

/// A plane measured in the base frame: its normal, and a point that it passes through. With the
/// plane (n, d) predicted in the base frame,
///   e = (Log_ñ(n), n · c̃ + d) ∈ R³ [rad, rad, m],
/// so that offset and direction are nearly independent: c̃ is the middle of the points seen.
class CEdgePlaneMeasurement : public CEdgeBase {
  DEFINE_VIRTUAL_SERIALIZABLE(CEdgePlaneMeasurement)
 public:
  /// ñ, c̃ and where the plane was seen, in the base frame.
  PlanePatch patch_base;
  std::uint32_t point_count = 0;

  int residualSize() const override { return 3; }

 protected:
  void writeMeasurement(mrpt::serialization::CArchive& out) const;
  void readMeasurement(mrpt::serialization::CArchive& in);
  template <class Edge>
  static std::shared_ptr<Edge> randomExample(std::mt19937_64& rng) {
    auto edge = std::make_shared<Edge>();
    const Pose3 T = randomPose(rng);
    edge->patch_base.normal = T.R.col(2);
    edge->patch_base.center = T.t;
    edge->patch_base.cells = {{-3, 2}, {0, 0}, {7, -1}};
    edge->point_count = 500;
    edge->setInformation(randomInformation(3, rng));
    return edge;
  }
};

/// A wall or ceiling seen from a keyframe (nodes: keyframe, plane).
class CEdgeKeyframePlane : public CEdgePlaneMeasurement {
  DEFINE_SERIALIZABLE(CEdgeKeyframePlane, dynemo)
 public:
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "keyframe_plane"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeKeyframePlane>(rng); }
};

/// The ground seen from a keyframe is its floor, the level plane z = ξ (nodes: keyframe, floor).
/// The part of the covariance that belongs to the normal says how far off the level the ground may
/// be.
class CEdgeFloorGround : public CEdgePlaneMeasurement {
  DEFINE_SERIALIZABLE(CEdgeFloorGround, dynemo)
 public:
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "floor_ground"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeFloorGround>(rng); }
};

/// Two walls are parallel: e = n_1 × n_2 ∈ R³ (nodes: plane, plane).
class CEdgePlaneParallel : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgePlaneParallel, dynemo)
 public:
  int residualSize() const override { return 3; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "plane_parallel"; }
  static Ptr example(std::mt19937_64& rng);
};

/// Two walls are at right angles: e = n_1 · n_2 (nodes: plane, plane).
class CEdgePlanePerpendicular : public CEdgeBase {
  DEFINE_SERIALIZABLE(CEdgePlanePerpendicular, dynemo)
 public:
  int residualSize() const override { return 1; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;
  const char* kind() const override { return "plane_perpendicular"; }
  static Ptr example(std::mt19937_64& rng);
};

}  // namespace dynemo
