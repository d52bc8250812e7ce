// The system on one page: frames in, a jointly optimised dynamic scene graph out (paper, Fig. 2).
#pragma once

#include <mrpt/system/COutputLogger.h>

#include <map>
#include <memory>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/exporters/run_result.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/life/keyframe_trail.h"
#include "dynemo/loops/loop_closer.h"
#include "dynemo/mapping/delta_builder.h"
#include "dynemo/mapping/keyframe_policy.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/pipeline/frame_refinement.h"
#include "dynemo/pipeline/params.h"
#include "dynemo/pipeline/robot_tracker.h"
#include "dynemo/pipeline/stage_timer.h"

namespace dynemo {

/// One optimisation of the run, as listed in optimizations.csv.
struct OptimizationRecord {
  std::uint64_t frame = 0;
  Stamp stamp;
  OptimizationReport report;
};

class SlamPipeline : public mrpt::system::COutputLogger {
 public:
  /// `rawlog_odometry`: the frames carry the log's odometry. The entity models must outlive the
  /// pipeline. Throws ConfigError on parameters that cannot work together.
  SlamPipeline(const DynemoParams& params, const EntityModels& models, bool rawlog_odometry);
  ~SlamPipeline() override;

  /// Records or replays the front-end's results; before the first frame. The cache must outlive the
  /// pipeline.
  void useCache(FrontEndCache& cache);

  /// Takes the next frame, in order of time. A frame that becomes a keyframe may be added to the
  /// graph with the next call only, or with finish(): see KeyframeDeskew. `timing` already holds
  /// what the ingest took.
  void process(SensorFrame frame, FrameTiming& timing);

  /// Final optimisation, trajectory and covariances. More frames may follow.
  void finish();
  /// Brings frames() up to date with the graph as it stands.
  void updateTrajectory();

  const CSceneGraph& graph() const { return graph_; }
  /// Frames so far; T_map_base is current as of the last finish().
  const std::vector<FramePose>& frames() const { return frames_; }
  RunResult result() const {
    return {graph_, frames_, entity_covariances_, keyframes_without_closures_, &plane_covariances_};
  }
  /// Covariance of the drift T_map_odom's right tangent as of the last finish(), when the gauge
  /// allows it.
  const std::optional<Matrix6>& driftCovariance() const { return drift_covariance_; }
  const std::vector<OptimizationRecord>& optimizations() const { return optimizations_; }
  /// Keyframes that have left the graph.
  std::size_t keyframesLeft() const { return trail_.left(); }
  /// Every decision about a loop closure so far.
  const std::vector<LoopRecord>& loops() const { return loops_.records(); }
  /// Counted warnings of all stages.
  std::map<std::string, std::uint64_t> warnings() const;
  /// Why the run as a whole should not be trusted; one sentence for each reason.
  std::vector<std::string> doubts() const;

 private:
  /// Where the robot is at a frame.
  struct RobotState {
    Pose3 T_odom_base;
    Pose3 T_map_base;  ///< predicted from the odometry and the drift so far
  };

  /// A frame that becomes a keyframe.
  struct Chosen {
    SensorFrame frame;
    RobotState robot;
    std::uint32_t reasons = 0;
    std::vector<EntityObservation> observations;
    Matrix6 odometry_covariance = Matrix6::Identity(), step_covariance = Matrix6::Identity();
    std::optional<SweepMotion> motion;  ///< during its sweep
  };

  /// The robot's motion and the entities in view: in this order, except where the motion is to be
  /// found without the points on agents.
  std::vector<EntityObservation> look(SensorFrame& frame, FrameTiming& timing);
  void estimateMotion(SensorFrame& frame, const PointIndices& ignored, FrameTiming& timing);
  std::vector<EntityObservation> detect(const SensorFrame& frame, FrameTiming& timing);
  /// T_odom_base.
  Pose3 locate(const SensorFrame& frame, const std::vector<EntityObservation>& observations,
               FrameTiming& timing);
  std::uint32_t decide(const SensorFrame& frame, const RobotState& robot,
                       const std::vector<EntityObservation>& observations, FrameTiming& timing);
  void record(const SensorFrame& frame, const RobotState& robot, FrameMeasurements measurements);
  Chosen choose(SensorFrame frame, const RobotState& robot, std::uint32_t reasons,
                std::vector<EntityObservation> observations);
  /// Whether the next frame tells more of how the robot moved during the sweep.
  bool waitsForNext(const Chosen& chosen) const;
  void addWaiting(FrameTiming& timing);
  void add(Chosen chosen, FrameTiming& timing);
  KeyframeData select(Chosen& chosen, FrameTiming& timing);
  void map(const KeyframeData& keyframe, FrameTiming& timing);
  void closeLoops(FrameTiming& timing);
  /// Takes keyframes out of the graph where there are more than it needs.
  void makeRoom(FrameTiming& timing);
  void optimize(const SensorFrame& frame, FrameTiming& timing);

  /// Planes of the scan without the faces of entities, and which of them is the ground.
  void seePlanes(const Scan& scan, KeyframeData& keyframe) const;
  /// What the graph knows, with its uncertainty, of what the keyframe observes.
  void associate(KeyframeData& keyframe);
  std::optional<KeyframePrediction> predict(const KeyframeData& keyframe);
  void settleLoops();
  /// Moves the frames between keyframes to where the objects they saw put them.
  void refineTrajectory();
  void recordOptimization(std::uint64_t frame_index, Stamp stamp, OptimizationReport report);
  void updateCovariances();

  DynemoParams params_;
  bool entities_described_;
  RobotTracker tracker_;
  AgentPoints agent_points_;
  std::vector<std::unique_ptr<EntityDetector>> detectors_;
  std::unique_ptr<PlaneExtractor> plane_extractor_;
  KeyframePolicy policy_;
  DeltaBuilder builder_;
  LoopCloser loops_;
  Optimizer optimizer_;

  CSceneGraph graph_;
  std::optional<Chosen> waiting_;  ///< until the motion to the next frame is known
  std::vector<FramePose> frames_;
  std::vector<FrameMeasurements> measurements_;  ///< of each frame
  KeyframeTrail trail_;
  std::vector<std::size_t>
      keyframe_of_frame_;  ///< in the trail: the latest keyframe at or before each frame
  std::map<NodeId, Matrix6> entity_covariances_;
  std::map<NodeId, Matrix3> plane_covariances_;
  std::vector<Pose3> keyframes_without_closures_;
  std::optional<Matrix6> drift_covariance_;
  std::vector<OptimizationRecord> optimizations_;
  std::map<std::string, std::uint64_t> warnings_;
};

}  // namespace dynemo
