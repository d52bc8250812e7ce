#include <mrpt/serialization/CArchive.h>

#include "archive.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/node_plane.h"

using mrpt::serialization::CArchive;

IMPLEMENTS_SERIALIZABLE(CNodePlane, CNodeBase, dynemo)
IMPLEMENTS_VIRTUAL_SERIALIZABLE(CEdgePlaneMeasurement, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeKeyframePlane, CEdgePlaneMeasurement, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeFloorGround, CEdgePlaneMeasurement, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgePlaneParallel, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgePlanePerpendicular, CEdgeBase, dynemo)

namespace dynemo {
namespace {

constexpr double kUnitTolerance = 1e-6;

Pose3 poseOf(const double* state) {
  return {Eigen::Map<const Matrix3>(state + 3), Eigen::Map<const Vector3>(state)};
}

void put(CArchive& out, const Vector3& v) {
  for (int i = 0; i < 3; ++i) out << v[i];
}

void get(CArchive& in, Vector3& v) {
  for (int i = 0; i < 3; ++i) getFinite(in, v[i]);
}

void getUnit(CArchive& in, Vector3& v) {
  get(in, v);
  if (std::abs(v.norm() - 1.0) > kUnitTolerance)
    throw DataError("a stored normal is not of unit length");
}

void put(CArchive& out, const Plane3& plane) {
  put(out, plane.normal);
  out << plane.d_m;
}

void get(CArchive& in, Plane3& plane) {
  getUnit(in, plane.normal);
  getFinite(in, plane.d_m);
}

/// Residual of a measured plane and its derivatives by the base's pose, and by the plane in the
/// map: J_plane is by (n, d) of the ambient R⁴.
struct PlaneResidual {
  Vector3 e;
  Eigen::Matrix<double, 3, 6> J_pose;
  Eigen::Matrix<double, 3, 4> J_plane;
};

PlaneResidual planeResidual(const PlanePatch& measured, const Pose3& T_map_base,
                            const Plane3& plane_map) {
  const Vector3 n_base = T_map_base.R.transpose() * plane_map.normal;
  const Vector3 c_map = T_map_base * measured.center;
  const SphereLog log = sphereLog(measured.normal, n_base);
  PlaneResidual r;
  r.e << log.w, plane_map.distance(c_map);
  r.J_pose.topLeftCorner<2, 3>().setZero();
  r.J_pose.topRightCorner<2, 3>() = log.J_w_v * skew(n_base);
  r.J_pose.bottomLeftCorner<1, 3>() = n_base.transpose();
  r.J_pose.bottomRightCorner<1, 3>() = measured.center.cross(n_base).transpose();
  r.J_plane.topLeftCorner<2, 3>() = log.J_w_v * T_map_base.R.transpose();
  r.J_plane.topRightCorner<2, 1>().setZero();
  r.J_plane.bottomLeftCorner<1, 3>() = c_map.transpose();
  r.J_plane(2, 3) = 1.0;
  return r;
}

}  // namespace

Plane3 CNodePlane::planeFromState(const double* s) { return {Eigen::Map<const Vector3>(s), s[3]}; }

void CNodePlane::planeToState(const Plane3& plane, double* out) {
  Eigen::Map<Vector3>{out} = plane.normal;
  out[3] = plane.d_m;
}

void CNodePlane::retract(const double* state, const double* delta, double* out) const {
  planeToState(planeFromState(state).retract(Eigen::Map<const Vector3>(delta)), out);
}

CNodePlane::Ptr CNodePlane::example(std::mt19937_64& rng) {
  auto node = std::make_shared<CNodePlane>();
  for (Plane3* plane : {&node->plane_map, &node->plane_map_first}) {
    const Pose3 T = randomPose(rng);
    *plane = Plane3::through(T.t, T.R.col(0));
  }
  return node;
}

std::uint8_t CNodePlane::serializeGetVersion() const { return 0; }
void CNodePlane::serializeTo(CArchive& out) const {
  writeBase(out);
  put(out, plane_map);
  put(out, plane_map_first);
}
void CNodePlane::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  get(in, plane_map);
  get(in, plane_map_first);
}

void CEdgePlaneMeasurement::writeMeasurement(CArchive& out) const {
  writeBase(out);
  put(out, patch_base.center);
  put(out, patch_base.normal);
  out << point_count;
  out.WriteAs<std::uint32_t>(patch_base.cells.size());
  for (const auto& cell : patch_base.cells) out << cell[0] << cell[1];
}

void CEdgePlaneMeasurement::readMeasurement(CArchive& in) {
  readBase(in);
  get(in, patch_base.center);
  getUnit(in, patch_base.normal);
  in >> point_count;
  const std::uint32_t n = getLength(in, 10'000'000);
  patch_base.cells.clear();
  for (std::uint32_t i = 0; i < n; ++i) {
    std::array<std::int16_t, 2> cell;
    in >> cell[0] >> cell[1];
    patch_base.cells.push_back(cell);
  }
}

void CEdgeKeyframePlane::evaluate(std::span<const double* const> states, Residual& e,
                                  Jacobians* J) const {
  const Plane3 plane = CNodePlane::planeFromState(states[1]);
  const PlaneResidual r = planeResidual(patch_base, poseOf(states[0]), plane);
  e = r.e;
  if (!J) return;
  (*J)[0] = r.J_pose;
  (*J)[1].resize(3, 3);
  (*J)[1].leftCols<2>() = r.J_plane.leftCols<3>() * orthogonalBasis(plane.normal);
  (*J)[1].rightCols<1>() = r.J_plane.rightCols<1>();
}

void CEdgeFloorGround::evaluate(std::span<const double* const> states, Residual& e,
                                Jacobians* J) const {
  const PlaneResidual r =
      planeResidual(patch_base, poseOf(states[0]), {Vector3::UnitZ(), -*states[1]});
  e = r.e;
  if (!J) return;
  (*J)[0] = r.J_pose;
  (*J)[1] = -r.J_plane.rightCols<1>();
}

#define DYNEMO_SERIALIZE_PLANE_MEASUREMENT(Class)                         \
  std::uint8_t Class::serializeGetVersion() const { return 0; }           \
  void Class::serializeTo(CArchive& out) const { writeMeasurement(out); } \
  void Class::serializeFrom(CArchive& in, std::uint8_t version) {         \
    if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);  \
    readMeasurement(in);                                                  \
  }
DYNEMO_SERIALIZE_PLANE_MEASUREMENT(CEdgeKeyframePlane)
DYNEMO_SERIALIZE_PLANE_MEASUREMENT(CEdgeFloorGround)

void CEdgePlaneParallel::evaluate(std::span<const double* const> states, Residual& e,
                                  Jacobians* J) const {
  const Vector3 n1 = CNodePlane::planeFromState(states[0]).normal,
                n2 = CNodePlane::planeFromState(states[1]).normal;
  e = n1.cross(n2);
  if (!J) return;
  for (int i = 0; i < 2; ++i) (*J)[i].setZero(3, 3);
  (*J)[0].leftCols<2>() = -skew(n2) * orthogonalBasis(n1);
  (*J)[1].leftCols<2>() = skew(n1) * orthogonalBasis(n2);
}

void CEdgePlanePerpendicular::evaluate(std::span<const double* const> states, Residual& e,
                                       Jacobians* J) const {
  const Vector3 n1 = CNodePlane::planeFromState(states[0]).normal,
                n2 = CNodePlane::planeFromState(states[1]).normal;
  e.resize(1);
  e[0] = n1.dot(n2);
  if (!J) return;
  for (int i = 0; i < 2; ++i) (*J)[i].setZero(1, 3);
  (*J)[0].leftCols<2>() = n2.transpose() * orthogonalBasis(n1);
  (*J)[1].leftCols<2>() = n1.transpose() * orthogonalBasis(n2);
}

template <class Edge>
static std::shared_ptr<Edge> edgeWithInformation(int size, std::mt19937_64& rng) {
  auto edge = std::make_shared<Edge>();
  edge->setInformation(randomInformation(size, rng));
  return edge;
}
CEdgePlaneParallel::Ptr CEdgePlaneParallel::example(std::mt19937_64& rng) {
  return edgeWithInformation<CEdgePlaneParallel>(3, rng);
}
CEdgePlanePerpendicular::Ptr CEdgePlanePerpendicular::example(std::mt19937_64& rng) {
  return edgeWithInformation<CEdgePlanePerpendicular>(1, rng);
}

#define DYNEMO_SERIALIZE_BARE_EDGE(Class)                                \
  std::uint8_t Class::serializeGetVersion() const { return 0; }          \
  void Class::serializeTo(CArchive& out) const { writeBase(out); }       \
  void Class::serializeFrom(CArchive& in, std::uint8_t version) {        \
    if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version); \
    readBase(in);                                                        \
  }
DYNEMO_SERIALIZE_BARE_EDGE(CEdgePlaneParallel)
DYNEMO_SERIALIZE_BARE_EDGE(CEdgePlanePerpendicular)

}  // namespace dynemo
