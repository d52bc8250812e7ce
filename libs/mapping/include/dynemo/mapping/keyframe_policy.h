// When a frame becomes a keyframe (paper, Sec. III-B).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

enum class KeyframeMode { kBaseline, kDynamic };

/// By which motion the points of a keyframe's sweep are carried to its stamp, where its odometry
/// has not measured that motion itself.
enum class KeyframeDeskew {
  kNone,
  kPast,      ///< since the last frame: it lags behind by a sweep
  kNextFrame  ///< until the next frame, which the keyframe waits for
};

struct KeyframeParams {
  /// Baseline: robot motion only. Dynamic: also new and moved entities.
  KeyframeMode mode = KeyframeMode::kDynamic;
  KeyframeDeskew deskew = KeyframeDeskew::kNextFrame;
  /// δ_R of Eq. (1), translation and rotation tested separately.
  double robot_translation_m = 0.5;
  double robot_rotation_rad = 0.2617993877991494;  // 15°
  /// δ_E of Eq. (3); also beyond `entity_sigmas` standard deviations of the detection.
  double object_translation_m = 0.30;
  double object_rotation_rad = 0.35;
  double agent_translation_m = 0.50;
  double entity_sigmas = 3.0;
  /// A static object seen again this long after its last registered observation makes a keyframe.
  bool timer = true;
  double timer_s = 5.0;
  /// New and moved entities must be seen this often, consistently and within the window, before
  /// they count.
  int confirmations = 2;
  double confirmation_window_s = 1.0;
  /// Least time between keyframes that entities trigger: walkers would make one per frame.
  double min_interval_s = 0.5;
};
void fields(FieldVisitor& v, KeyframeParams& p);

/// One frame as the policy sees it.
struct KeyframeCandidate {
  Stamp stamp;
  Pose3 T_odom_base;
  Pose3 T_map_base;  ///< predicted: T_map_odom · T_odom_base
  const std::vector<EntityObservation>& observations;
};

class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeParams& params) : params_(params) {}

  /// The reasons (bitwise or of KeyframeReason) to make a keyframe of this frame; 0 for none. Keeps
  /// track of unconfirmed sightings, so every frame must be shown exactly once and in order.
  std::uint32_t decide(const KeyframeCandidate& frame, const CSceneGraph& graph);

 private:
  struct Sighting {
    int count = 0;
    Stamp last;
    Pose3 T_map_entity;
  };
  bool robotMoved(const KeyframeCandidate& frame, const CNodeKeyframe& last) const;
  bool entityMoved(const EntityObservation& observation, const Pose3& T_map_entity,
                   const CNodeEntity& last) const;
  /// Counts a sighting of a new or moved entity; true once it is confirmed.
  bool confirm(const EntityObservation& observation, const Pose3& T_map_entity);

  KeyframeParams params_;
  std::map<EntityId, Sighting> unconfirmed_;
};

}  // namespace dynemo
