// A robot that drives the same rectangle again and again, as a scene graph with drifting odometry.
#pragma once

#include <random>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo::test {

struct LoopGraphParams {
  int keyframes_per_lap = 24;
  double length_m = 8.0, width_m = 4.0;
  /// Noise of the odometry between two keyframes, and what its edges claim.
  double sigma_m = 0.02, sigma_rad = 0.004;
  double claimed_scale = 1.0;
  unsigned seed = 1;
};

/// Grows keyframe by keyframe, as the pipeline does it: each is added at the odometry's prediction.
class LoopGraph {
 public:
  explicit LoopGraph(const LoopGraphParams& params = {});

  /// Adds the next keyframe. Its scan is a handful of points without meaning.
  const CNodeKeyframe& addKeyframe();
  /// An observation of an entity from the newest keyframe, at the true pose in the map given.
  const CNodeEntity& see(EntityId entity, const Pose3& T_map_entity,
                         SemanticClass semantic_class = SemanticClass::kObject,
                         PointIndices fragment = {});
  void optimize();

  /// The true pose of the keyframe of that index.
  Pose3 truth(std::size_t keyframe) const;
  Pose3 trueRelative(std::size_t a, std::size_t b) const { return truth(a).inverse() * truth(b); }
  /// Root mean square distance of the keyframes' estimates from the truth.
  double rmse_m() const;

  CSceneGraph graph;
  Optimizer optimizer;

 private:
  LoopGraphParams params_;
  std::mt19937_64 rng_;
  Pose3 T_odom_base_;
};

}  // namespace dynemo::test
