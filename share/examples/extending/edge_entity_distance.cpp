// A factor between two nodes.
#include "edge_entity_distance.h"

#include <mrpt/serialization/CArchive.h>

#include <algorithm>

#include "archive.h"

using mrpt::serialization::CArchive;

IMPLEMENTS_SERIALIZABLE(CEdgeEntityDistance, CEdgeBase, dynemo)

namespace dynemo {

void CEdgeEntityDistance::evaluate(std::span<const double* const> states, Residual& e,
                                   Jacobians* J) const {
  // The state of a pose node: translation, then the rotation matrix by columns (CNodePose).
  const Eigen::Map<const Vector3> t_a(states[0]), t_b(states[1]);
  const Eigen::Map<const Matrix3> R_a(states[0] + 3), R_b(states[1] + 3);
  const double distance = (t_b - t_a).norm();
  e.resize(1);
  e[0] = distance - distance_m;
  if (!J) return;
  // t ⊞ d = t + R d: the derivative by d is uᵀ R, and there is none by the rotation.
  const Vector3 u = (t_b - t_a) / std::max(distance, 1e-9);
  for (int i = 0; i < 2; ++i) (*J)[i].setZero(1, 6);
  (*J)[0].leftCols<3>() = -u.transpose() * R_a;
  (*J)[1].leftCols<3>() = u.transpose() * R_b;
}

CEdgeEntityDistance::Ptr CEdgeEntityDistance::example(std::mt19937_64& rng) {
  auto edge = std::make_shared<CEdgeEntityDistance>();
  edge->distance_m = 1.5;
  edge->setInformation(randomInformation(1, rng));
  return edge;
}

std::uint8_t CEdgeEntityDistance::serializeGetVersion() const { return 0; }
void CEdgeEntityDistance::serializeTo(CArchive& out) const {
  writeBase(out);
  out << distance_m;
}
void CEdgeEntityDistance::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  getFinite(in, distance_m);
}

}  // namespace dynemo
