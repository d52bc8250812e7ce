// Where every keyframe of a run is, also those that have left the graph.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// All keyframes in the order of their creation. One that leaves the graph is hung on a few
/// keyframes nearby that stay, and moves with the mean of them from then on.
class KeyframeTrail {
 public:
  void add(const CNodeKeyframe& keyframe);
  /// Before the keyframes are taken out of the graph. Throws std::out_of_range when one is not the
  /// trail's, and std::logic_error when the graph has no others.
  void hang(std::span<const NodeId> leaving, const CSceneGraph& graph);

  std::size_t size() const { return entries_.size(); }
  Stamp stamp(std::size_t index) const { return entries_[index].stamp; }
  const Pose3& T_odom_base(std::size_t index) const { return entries_[index].T_odom_base; }
  /// By the graph's present estimates.
  Pose3 T_map_base(std::size_t index, const CSceneGraph& graph) const;
  /// Keyframes that have left.
  std::size_t left() const { return left_; }

 private:
  /// Another entry, and where this one was from there when it was hung on it. A long life has many:
  /// to a millionth of the distance.
  struct Hook {
    Hook(std::size_t other, const Pose3& T_other_this);
    Pose3 T_other_this() const;
    std::uint32_t entry;
    std::array<float, 3> t_m;
    std::array<float, 4> q_xyzw;
  };
  struct Entry {
    NodeId id{};
    Stamp stamp;
    Pose3 T_odom_base;
    /// In hooks_; none while it is in the graph.
    std::uint32_t first_hook = 0, hooks = 0;
  };
  std::size_t indexOf(NodeId keyframe) const;
  /// Of an entry that others hang on: where it has left itself, by the first of its hooks alone.
  Pose3 byFirstHooks(std::size_t index, const CSceneGraph& graph) const;

  // Grow at the end for ever, without copies of what is there.
  std::deque<Entry> entries_;
  std::deque<Hook> hooks_;
  std::size_t left_ = 0;
};

}  // namespace dynemo
