#pragma once

#include "dynemo/core/plane3.h"
#include "dynemo/graph/node.h"

namespace dynemo {

/// A wall, ceiling or other large plane face: state π = (n, d) in the map frame, n · p + d = 0 with
/// n towards the free side; 3 degrees of freedom (core/plane3.h). Where the plane ends is known
/// from the observations alone, its CEdgeKeyframePlane edges (graph/edge_plane.h).
class CNodePlane : public CNodeBase {
  DEFINE_SERIALIZABLE(CNodePlane, dynemo)
 public:
  static constexpr int kStateSize = 4;
  static constexpr int kTangentSize = 3;

  Plane3 plane_map;
  /// Estimate when the node was created.
  Plane3 plane_map_first;

  int stateSize() const override { return kStateSize; }
  int tangentSize() const override { return kTangentSize; }
  void readState(double* out) const override { planeToState(plane_map, out); }
  void writeState(const double* state) override { plane_map = planeFromState(state); }
  void retract(const double* state, const double* delta, double* out) const override;
  const char* kind() const override { return "plane"; }
  static Ptr example(std::mt19937_64& rng);

  static Plane3 planeFromState(const double* state);
  static void planeToState(const Plane3& plane, double* out);
};

}  // namespace dynemo
