// Made-up sessions whose truth is known: a robot that stands and looks around, boxes, people.
#pragma once

#include <cstdint>
#include <string>

#include "dynemo/graph/session.h"

namespace dynemo::test {

inline Stamp at(double seconds) {
  return {1'700'000'000'000'000'000 + static_cast<std::int64_t>(seconds * 1e9)};
}

/// Builds a session observation by observation. Poses of the constructor's frame: everything is
/// expressed in a map whose pose in the world is T_world_map.
class SessionBuilder {
 public:
  explicit SessionBuilder(const Pose3& T_world_map = {}) : T_map_world_(T_world_map.inverse()) {}

  /// A keyframe without a scan.
  NodeId keyframe(double seconds, const Pose3& T_world_base = {});
  /// A keyframe at the world's origin whose scan has a wall at x = 6 m behind boxes of 0.5 m at the
  /// given positions; points on a box belong to it when it is observed next.
  NodeId scan(double seconds, const std::vector<Vector3>& boxes_world);
  /// An observation from the last keyframe; its fragment is the scan's points on the box there.
  void see(std::int64_t entity, double seconds, const Pose3& T_world_entity, bool moved = false,
           SemanticClass semantic_class = SemanticClass::kObject, const std::string& name = "");

  Session session;

 private:
  Pose3 T_map_world_;
};

}  // namespace dynemo::test
