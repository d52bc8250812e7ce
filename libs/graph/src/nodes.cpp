#include <mrpt/serialization/CArchive.h>

#include "archive.h"
#include "dynemo/graph/node.h"
#include "dynemo/graph/node_entity.h"
#include "dynemo/graph/node_floor.h"
#include "dynemo/graph/node_keyframe.h"

using mrpt::serialization::CArchive;

IMPLEMENTS_VIRTUAL_SERIALIZABLE(CNodeBase, CSerializable, dynemo)
IMPLEMENTS_VIRTUAL_SERIALIZABLE(CNodePose, CNodeBase, dynemo)
IMPLEMENTS_SERIALIZABLE(CNodeKeyframe, CNodePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CNodeEntity, CNodePose, dynemo)
IMPLEMENTS_SERIALIZABLE(CNodeFloor, CNodeBase, dynemo)

namespace dynemo {

void CNodeBase::writeBase(CArchive& out) const { out << id.value; }
void CNodeBase::readBase(CArchive& in) { in >> id.value; }

Pose3 CNodePose::poseFromState(const double* s) {
  return {Eigen::Map<const Matrix3>(s + 3), Eigen::Map<const Vector3>(s)};
}

void CNodePose::poseToState(const Pose3& T, double* out) {
  Eigen::Map<Vector3>{out} = T.t;
  Eigen::Map<Matrix3>{out + 3} = T.R;
}

void CNodePose::retract(const double* state, const double* delta, double* out) const {
  poseToState(poseFromState(state).retract(Eigen::Map<const Vector6>(delta)), out);
}

void CNodePose::writePose(CArchive& out) const {
  writeBase(out);
  put(out, T_map_node);
  put(out, T_map_node_first);
}

void CNodePose::readPose(CArchive& in) {
  readBase(in);
  get(in, T_map_node);
  get(in, T_map_node_first);
}

std::string keyframeReasonText(std::uint32_t reasons) {
  static constexpr std::pair<KeyframeReason, const char*> kNames[] = {
      {KeyframeReason::kFirst, "first"},
      {KeyframeReason::kRobotMoved, "robot_moved"},
      {KeyframeReason::kNewEntity, "new_entity"},
      {KeyframeReason::kEntityMoved, "entity_moved"},
      {KeyframeReason::kTimerExpired, "timer_expired"}};
  std::string text;
  for (const auto& [reason, name] : kNames) {
    if (reasons & static_cast<std::uint32_t>(reason))
      text += (text.empty() ? "" : "+") + std::string(name);
  }
  return text;
}

const char* semanticClassName(SemanticClass c) {
  return c == SemanticClass::kAgent ? "agent" : "object";
}

std::uint8_t CNodeKeyframe::serializeGetVersion() const { return 0; }

void CNodeKeyframe::serializeTo(CArchive& out) const {
  writePose(out);
  out << stamp.ns << frame_index << reasons << floor.has_value() << floor.value_or(NodeId{}).value;
  put(out, T_odom_base);
}

void CNodeKeyframe::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readPose(in);
  NodeId floor_id;
  in >> stamp.ns >> frame_index >> reasons;
  const bool has_floor = getBool(in);
  in >> floor_id.value;
  floor = has_floor ? std::optional(floor_id) : std::nullopt;
  get(in, T_odom_base);
}

std::uint8_t CNodeEntity::serializeGetVersion() const { return 0; }

void CNodeEntity::serializeTo(CArchive& out) const {
  writePose(out);
  out << entity.value << name << static_cast<std::uint8_t>(semantic_class) << keyframe.value
      << stamp.ns << moved;
  put(out, fragment);
}

void CNodeEntity::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readPose(in);
  std::uint8_t c = 0;
  in >> entity.value;
  get(in, name);
  in >> c >> keyframe.value >> stamp.ns;
  moved = getBool(in);
  if (c > 1) throw DataError("a stored entity has an unknown semantic class");
  semantic_class = static_cast<SemanticClass>(c);
  get(in, fragment);
}

// Version 1 adds the area.
std::uint8_t CNodeFloor::serializeGetVersion() const { return 1; }

void CNodeFloor::serializeTo(CArchive& out) const {
  writeBase(out);
  out << level_m << level_first_m << center_map_m.x() << center_map_m.y();
  out << !area_map_m.isEmpty();
  if (area_map_m.isEmpty()) return;
  for (const Vector2& corner : {area_map_m.min(), area_map_m.max()})
    out << corner.x() << corner.y();
}

void CNodeFloor::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version > 1) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  readBase(in);
  for (double* value : {&level_m, &level_first_m, &center_map_m.x(), &center_map_m.y()})
    getFinite(in, *value);
  area_map_m.setEmpty();
  if (version < 1 || !getBool(in)) return;
  Vector2 min, max;
  for (double* value : {&min.x(), &min.y(), &max.x(), &max.y()}) getFinite(in, *value);
  if ((min.array() > max.array()).any()) throw DataError("a stored area is empty");
  area_map_m = {min, max};
}

}  // namespace dynemo
