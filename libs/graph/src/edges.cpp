#include <mrpt/serialization/CArchive.h>

#include "archive.h"
#include "dynemo/core/plane3.h"
#include "dynemo/graph/edge.h"
#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/edge_summary.h"
#include "dynemo/graph/node.h"

using mrpt::serialization::CArchive;

IMPLEMENTS_VIRTUAL_SERIALIZABLE(CEdgeBase, CSerializable, dynemo)
IMPLEMENTS_VIRTUAL_SERIALIZABLE(CEdgeRelativePose, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeOdometry, CEdgeRelativePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeKeyframeEntity, CEdgeRelativePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeIntraEntity, CEdgeRelativePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeLoopClosure, CEdgeRelativePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeSummary, CEdgeRelativePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgePosePrior, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeFloorPrior, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeFloorEntity, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeAgentLine, CEdgeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CEdgeAgentVelocity, CEdgeBase, dynemo)

namespace dynemo {
namespace {

/// Where the translation and the height live in a pose node's state (CNodePose).
Eigen::Map<const Vector3> translationOf(const double* state) {
  return Eigen::Map<const Vector3>(state);
}
Eigen::Map<const Matrix3> rotationOf(const double* state) {
  return Eigen::Map<const Matrix3>(state + 3);
}

double uniform(std::mt19937_64& rng, double lo, double hi) {
  return lo + (hi - lo) * (static_cast<double>(rng() >> 11) * 0x1.0p-53);
}

}  // namespace

MatrixX randomInformation(int size, std::mt19937_64& rng) {
  MatrixX A(size, size);
  for (int r = 0; r < size; ++r)
    for (int c = 0; c < size; ++c) A(r, c) = uniform(rng, -1.0, 1.0);
  return A * A.transpose() + 0.5 * MatrixX::Identity(size, size);
}

Pose3 randomPose(std::mt19937_64& rng) {
  const auto r = [&](double a) { return uniform(rng, -a, a); };
  const Vector3 t(r(5), r(5), r(5));
  return {Eigen::Quaterniond(r(1), r(1), r(1), r(1)), t};
}

void CEdgeBase::setInformation(const MatrixX& information) {
  const auto U = squareRootInformation(information);
  if (!U || information.rows() != residualSize()) {
    throw DataError(std::string(kind()) +
                    " edge: its information matrix is not symmetric positive definite");
  }
  information_ = information;
  sqrt_information_ = *U;
}

void CEdgeBase::setCovariance(const MatrixX& covariance) {
  const auto information = invertSpd(covariance);
  if (!information) {
    throw DataError(std::string(kind()) +
                    " edge: its covariance is not symmetric positive definite");
  }
  setInformation(*information);
}

void CEdgeBase::writeBase(CArchive& out) const {
  out << id.value;
  out.WriteAs<std::uint32_t>(nodes.size());
  for (const NodeId node : nodes) out << node.value;
  out << static_cast<std::uint8_t>(kernel.type) << kernel.width;
  for (int c = 0; c < residualSize(); ++c)
    for (int r = 0; r <= c; ++r) out << information_(r, c);
}

void CEdgeBase::readBase(CArchive& in) {
  in >> id.value;
  nodes.resize(getLength(in, kMaxEdgeNodes));
  for (NodeId& node : nodes) in >> node.value;
  std::uint8_t type = 0;
  in >> type;
  if (type > static_cast<std::uint8_t>(KernelType::kGemanMcClure))
    throw DataError("a stored kernel is unknown");
  kernel.type = static_cast<KernelType>(type);
  getFinite(in, kernel.width);
  if (kernel.type != KernelType::kNone && kernel.width <= 0.0) {
    throw DataError("a stored kernel has no width");
  }
  MatrixX information(residualSize(), residualSize());
  for (int c = 0; c < residualSize(); ++c)
    for (int r = 0; r <= c; ++r) {
      in >> information(r, c);
      information(c, r) = information(r, c);
    }
  setInformation(information);
}

void CEdgeRelativePose::evaluate(std::span<const double* const> states, Residual& e,
                                 Jacobians* J) const {
  const auto R1 = rotationOf(states[0]), R2 = rotationOf(states[1]);
  const Vector3 t_12 = R1.transpose() * (translationOf(states[1]) - translationOf(states[0]));
  const Matrix3 R_12 = R1.transpose() * R2;
  const Matrix3 RD_T = T_1_2.R.transpose();
  const Vector3 w = logSO3(RD_T * R_12);
  e.resize(6);
  e.head<3>() = RD_T * (t_12 - T_1_2.t);
  e.tail<3>() = w;
  if (!J) return;
  const Matrix3 Jr_inv = rightJacobianInverseSO3(w);
  for (int i = 0; i < 2; ++i) (*J)[i].setZero(6, 6);
  (*J)[0].topLeftCorner<3, 3>() = -RD_T;
  (*J)[0].topRightCorner<3, 3>() = RD_T * skew(t_12);
  (*J)[0].bottomRightCorner<3, 3>() = -Jr_inv * R_12.transpose();
  (*J)[1].topLeftCorner<3, 3>() = RD_T * R_12;
  (*J)[1].bottomRightCorner<3, 3>() = Jr_inv;
}

void CEdgeRelativePose::writeRelativePose(CArchive& out) const {
  writeBase(out);
  put(out, T_1_2);
}

void CEdgeRelativePose::readRelativePose(CArchive& in) {
  readBase(in);
  get(in, T_1_2);
}

#define DYNEMO_SERIALIZE_PLAIN_RELATIVE_POSE(Class)                        \
  std::uint8_t Class::serializeGetVersion() const { return 0; }            \
  void Class::serializeTo(CArchive& out) const { writeRelativePose(out); } \
  void Class::serializeFrom(CArchive& in, std::uint8_t version) {          \
    if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);   \
    readRelativePose(in);                                                  \
  }
DYNEMO_SERIALIZE_PLAIN_RELATIVE_POSE(CEdgeOdometry)
DYNEMO_SERIALIZE_PLAIN_RELATIVE_POSE(CEdgeKeyframeEntity)
DYNEMO_SERIALIZE_PLAIN_RELATIVE_POSE(CEdgeLoopClosure)
DYNEMO_SERIALIZE_PLAIN_RELATIVE_POSE(CEdgeSummary)

std::uint8_t CEdgeIntraEntity::serializeGetVersion() const { return 0; }
void CEdgeIntraEntity::serializeTo(CArchive& out) const {
  writeRelativePose(out);
  out << motion_model;
}
void CEdgeIntraEntity::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readRelativePose(in);
  get(in, motion_model);
}

void CEdgePosePrior::evaluate(std::span<const double* const> states, Residual& e,
                              Jacobians* J) const {
  const auto R = rotationOf(states[0]);
  const Matrix3 RD_T = T_map_node.R.transpose();
  const Vector3 w = logSO3(RD_T * R);
  e.resize(6);
  e.head<3>() = RD_T * (translationOf(states[0]) - T_map_node.t);
  e.tail<3>() = w;
  if (!J) return;
  (*J)[0].setZero(6, 6);
  (*J)[0].topLeftCorner<3, 3>() = RD_T * R;
  (*J)[0].bottomRightCorner<3, 3>() = rightJacobianInverseSO3(w);
}

CEdgePosePrior::Ptr CEdgePosePrior::example(std::mt19937_64& rng) {
  auto edge = std::make_shared<CEdgePosePrior>();
  edge->T_map_node = randomPose(rng);
  edge->setInformation(randomInformation(6, rng));
  return edge;
}

std::uint8_t CEdgePosePrior::serializeGetVersion() const { return 0; }
void CEdgePosePrior::serializeTo(CArchive& out) const {
  writeBase(out);
  put(out, T_map_node);
}
void CEdgePosePrior::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  get(in, T_map_node);
}

void CEdgeFloorPrior::evaluate(std::span<const double* const> states, Residual& e,
                               Jacobians* J) const {
  e.resize(1);
  e[0] = *states[0] - level_m;
  if (J) (*J)[0].setOnes(1, 1);
}

CEdgeFloorPrior::Ptr CEdgeFloorPrior::example(std::mt19937_64& rng) {
  auto edge = std::make_shared<CEdgeFloorPrior>();
  edge->level_m = uniform(rng, -3.0, 3.0);
  edge->setInformation(randomInformation(1, rng));
  return edge;
}

std::uint8_t CEdgeFloorPrior::serializeGetVersion() const { return 0; }
void CEdgeFloorPrior::serializeTo(CArchive& out) const {
  writeBase(out);
  out << level_m;
}
void CEdgeFloorPrior::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  getFinite(in, level_m);
}

void CEdgeFloorEntity::evaluate(std::span<const double* const> states, Residual& e,
                                Jacobians* J) const {
  e.resize(1);
  e[0] = *states[0] - translationOf(states[1]).z() - offset_m;
  if (!J) return;
  (*J)[0].setOnes(1, 1);
  (*J)[1].setZero(1, 6);
  (*J)[1].leftCols<3>() = -rotationOf(states[1]).row(2);
}

CEdgeFloorEntity::Ptr CEdgeFloorEntity::example(std::mt19937_64& rng) {
  auto edge = std::make_shared<CEdgeFloorEntity>();
  edge->offset_m = uniform(rng, -2.0, 2.0);
  edge->setInformation(randomInformation(1, rng));
  return edge;
}

std::uint8_t CEdgeFloorEntity::serializeGetVersion() const { return 0; }
void CEdgeFloorEntity::serializeTo(CArchive& out) const {
  writeBase(out);
  out << offset_m;
}
void CEdgeFloorEntity::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  getFinite(in, offset_m);
}

void CEdgeAgentLine::evaluate(std::span<const double* const> states, Residual& e,
                              Jacobians* J) const {
  const auto R1 = rotationOf(states[0]), R2 = rotationOf(states[1]);
  const Eigen::Matrix<double, 2, 3> BT = orthogonalBasis(direction_entity).transpose();
  const Vector3 v = R1.transpose() * (translationOf(states[1]) - translationOf(states[0]));
  e = BT * v;
  if (!J) return;
  for (int i = 0; i < 2; ++i) (*J)[i].setZero(2, 6);
  (*J)[0].leftCols<3>() = -BT;
  (*J)[0].rightCols<3>() = BT * skew(v);
  (*J)[1].leftCols<3>() = BT * R1.transpose() * R2;
}

CEdgeAgentLine::Ptr CEdgeAgentLine::example(std::mt19937_64& rng) {
  auto edge = std::make_shared<CEdgeAgentLine>();
  edge->direction_entity = randomPose(rng).R.col(0);
  edge->setInformation(randomInformation(2, rng));
  return edge;
}

std::uint8_t CEdgeAgentLine::serializeGetVersion() const { return 0; }
void CEdgeAgentLine::serializeTo(CArchive& out) const {
  writeBase(out);
  for (int i = 0; i < 3; ++i) out << direction_entity[i];
}
void CEdgeAgentLine::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  for (int i = 0; i < 3; ++i) getFinite(in, direction_entity[i]);
  if (direction_entity.isZero()) throw DataError("a stored direction of motion is zero");
}

void CEdgeAgentVelocity::evaluate(std::span<const double* const> states, Residual& e,
                                  Jacobians* J) const {
  const auto t1 = translationOf(states[0]), t2 = translationOf(states[1]),
             t3 = translationOf(states[2]);
  e = (t3 - t2) / dt_23_s - (t2 - t1) / dt_12_s;
  if (!J) return;
  const double factors[3] = {1.0 / dt_12_s, -1.0 / dt_23_s - 1.0 / dt_12_s, 1.0 / dt_23_s};
  for (int i = 0; i < 3; ++i) {
    (*J)[i].setZero(3, 6);
    (*J)[i].leftCols<3>() = factors[i] * rotationOf(states[i]);
  }
}

CEdgeAgentVelocity::Ptr CEdgeAgentVelocity::example(std::mt19937_64& rng) {
  auto edge = std::make_shared<CEdgeAgentVelocity>();
  edge->dt_12_s = uniform(rng, 0.2, 2.0);
  edge->dt_23_s = uniform(rng, 0.2, 2.0);
  edge->setInformation(randomInformation(3, rng));
  return edge;
}

std::uint8_t CEdgeAgentVelocity::serializeGetVersion() const { return 0; }
void CEdgeAgentVelocity::serializeTo(CArchive& out) const {
  writeBase(out);
  out << dt_12_s << dt_23_s;
}
void CEdgeAgentVelocity::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  getFinite(in, dt_12_s);
  getFinite(in, dt_23_s);
  if (dt_12_s <= 0.0 || dt_23_s <= 0.0) throw DataError("a stored time difference is not positive");
}

}  // namespace dynemo
