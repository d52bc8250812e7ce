#pragma once

#include <memory>
#include <optional>
#include <string>

#include "dynemo/core/point_cloud.h"
#include "dynemo/graph/node.h"

namespace dynemo {

/// Which condition made a keyframe; several may hold at once.
enum class KeyframeReason : std::uint32_t {
  kFirst = 1,
  kRobotMoved = 2,    ///< paper, Eq. (1)
  kNewEntity = 4,     ///< Eq. (2)
  kEntityMoved = 8,   ///< Eq. (3)
  kTimerExpired = 16  ///< a static entity's timer
};

/// "robot_moved+new_entity"
std::string keyframeReasonText(std::uint32_t reasons);

/// The robot's base at a selected frame: state T_map_base ∈ SE(3).
class CNodeKeyframe : public CNodePose {
  DEFINE_SERIALIZABLE(CNodeKeyframe, dynemo)
 public:
  Stamp stamp;
  /// Position in the sequence of frames of the run.
  std::uint64_t frame_index = 0;
  /// Base pose in the odometry frame at the stamp; the keyframe's prior in the absence of drift.
  Pose3 T_odom_base;
  /// Bitwise or of KeyframeReason.
  std::uint32_t reasons = 0;
  /// The floor the robot stands on, when known.
  std::optional<NodeId> floor;
  /// The LiDAR scan, shared and immutable; not part of the serialised node (a session stores clouds
  /// apart).
  std::shared_ptr<const Scan> scan;

  const Pose3& T_map_base() const { return T_map_node; }
  const char* kind() const override { return "keyframe"; }
};

}  // namespace dynemo
