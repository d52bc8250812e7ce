// The odometry between any two keyframes.
#pragma once

#include <vector>

#include "dynemo/graph/scene_graph.h"
#include "dynemo/loops/pose_estimate.h"

namespace dynemo {

/// Keyframes by their index in CSceneGraph::keyframes().
class OdometryChain {
 public:
  /// Takes over the keyframes and odometry edges that were added since the last call.
  void extend(const CSceneGraph& graph);
  /// A keyframe leaves the graph: the odometry to and from it becomes one link, and those after it
  /// count one less. Throws std::out_of_range when there is none of that index.
  void remove(std::size_t keyframe);

  std::size_t size() const { return links_.size(); }
  /// Path driven from the first keyframe, in straight lines between keyframes [m].
  double path_m(std::size_t keyframe) const { return links_[keyframe].path_m; }
  double pathBetween_m(std::size_t a, std::size_t b) const;

  /// T_a_b by the odometry edges alone; empty when its least certain direction has more than
  /// `max_sigma_m`, or an edge is missing in between.
  std::optional<PoseEstimate> between(std::size_t a, std::size_t b, double max_sigma_m) const;

 private:
  struct Link {
    double path_m = 0.0;
    /// From the keyframe before; empty for the first, and where no odometry edge leads here.
    std::optional<PoseEstimate> previous_this;
  };
  std::vector<Link> links_;
};

}  // namespace dynemo
