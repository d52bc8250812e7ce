// A made-up building and robot: scene graphs with every kind of edge, of any size, for tests and
// benchmarks.
#pragma once

#include <map>
#include <random>

#include "dynemo/graph/plane_patch.h"
#include "dynemo/graph/scene_graph.h"

namespace dynemo::test {

struct WorldParams {
  std::uint64_t seed = 1;
  int keyframes_per_lap = 64;
  int laps_per_floor = 4;
  /// Of the building; after the last the robot begins again with the first. 0: without end.
  int storeys = 0;
  int observations_per_keyframe = 3;
  /// Every n-th keyframe after the first lap closes a loop; 0 never.
  int loop_every = 10;
  /// Robust kernels of all kinds on the detections, and wrong detections for them.
  bool outliers = false;
  bool pose_prior = true, floor_prior = true;
  /// Walls, and the ground as a plane.
  bool planes = true;
};

/// The robot drives laps, floor by floor, sees walls, the ground and objects, and follows an agent.
/// Each call makes the delta of one more keyframe, with estimates as a front-end would give them:
/// dead reckoning from the graph's last keyframe.
class GeneratedWorld {
 public:
  explicit GeneratedWorld(const WorldParams& params) : params_(params), rng_(params.seed) {}
  GraphDelta nextKeyframe(const CSceneGraph& graph);

 private:
  double gauss();
  Pose3 noisy(const Pose3& T, double sigma_m, double sigma_rad);
  Pose3 robotAt(int k) const;
  int floorAt(int k) const;
  /// The last keyframe before that was taken here; negative when there is none.
  int lastVisit(int k) const;
  Pose3 objectPose(int floor, int index) const;
  Pose3 agentPose(int k) const;
  RobustKernel detectionKernel();
  void observe(const CSceneGraph& graph, EntityId entity, const Pose3& T_map_entity,
               SemanticClass c, NodeId keyframe, const Pose3& T_map_base_estimate,
               GraphDelta& delta);
  void constrainAgent(const CSceneGraph& graph, const CNodeEntity& newest, GraphDelta& delta);
  NodeId floorNode(const CSceneGraph& graph, GraphDelta& delta);
  Plane3 wall(int floor, int index) const;
  /// The plane as the robot sees it, with noise.
  PlanePatch measured(const Plane3& plane_map);
  template <class Edge>
  void seePlane(const CSceneGraph& graph, GraphDelta& delta, NodeId keyframe, NodeId seen,
                const Plane3& plane_map);
  /// The ground, and one of the walls.
  void seeStructure(const CSceneGraph& graph, GraphDelta& delta, const CNodeKeyframe& keyframe);

  WorldParams params_;
  std::mt19937_64 rng_;
  int k_ = 0;
  std::map<std::pair<int, int>, NodeId> walls_;  ///< by floor and index
};

/// A graph of `keyframes` keyframes, none of it optimised yet.
CSceneGraph generateGraph(const WorldParams& params, int keyframes);

}  // namespace dynemo::test
