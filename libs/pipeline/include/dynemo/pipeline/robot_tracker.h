// Where the robot is at each frame, and how uncertain its motion since the last keyframe is.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dynemo/graph/scene_graph.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/odometry/scan_odometry.h"
#include "dynemo/odometry/sweep_motion.h"
#include "dynemo/perception/entity_observation.h"
#include "dynemo/pipeline/front_end_cache.h"
#include "dynemo/pipeline/params.h"

namespace dynemo {

/// Whether the motion is estimated from the scans, for a log that carries odometry or not.
bool usesLidarOdometry(const RobotOdometryParams& params, bool rawlog_odometry);

class RobotTracker {
 public:
  /// `rawlog_odometry`: the log carries odometry. `planes`: how the ground is found, on which LiDAR
  /// odometry starts level. Throws ConfigError when the configured source is not to be had.
  RobotTracker(const RobotOdometryParams& params, bool rawlog_odometry,
               const PlaneParams& planes = {}, const SweepDistortionParams& distortion = {});
  ~RobotTracker();

  /// Records or replays the LiDAR odometry, where there is any; before the first frame.
  void useCache(FrontEndCache& cache);

  /// Before estimate(), for those who must look at the frame first: with LiDAR odometry, replaces
  /// the frame's, its images' and detections' odometry by what the motion so far makes expect.
  void predict(SensorFrame& frame);

  /// First step of a frame: with LiDAR odometry, replaces the frame's and its images' odometry by
  /// the estimate, carried to each stamp. The scan's points at `ignored`, ascending, take no part.
  void estimate(SensorFrame& frame, std::span<const std::uint32_t> ignored = {});

  /// Second step, when the entities are detected: T_odom_base of the frame. Where there is no
  /// odometry the mapped entities in view tell where the robot is, else it is taken to stand still.
  Pose3 locate(const SensorFrame& frame, const std::vector<EntityObservation>& observations,
               const CSceneGraph& graph);

  /// Motion during the sweep of the frame that was located last, as far as it is known by then.
  const std::optional<SweepMotion>& sweepMotion() const { return motion_; }
  /// Whether that was found in the sweep itself: else the next frame tells more of it.
  bool knowsSweepMotion() const;
  /// Mean motion from the frame before to the frame that was located last.
  const std::optional<SweepMotion>& motionSinceLast() const { return mean_motion_; }

  /// Covariance of the right tangent of the motion since the last keyframe, for a keyframe made of
  /// this frame.
  Matrix6 covarianceSinceKeyframe(const SensorFrame& frame, const CSceneGraph& graph) const;
  /// Of the motion since the frame before the one that was located last.
  const Matrix6& stepCovariance() const { return step_covariance_; }
  void keyframeMade(const SensorFrame& frame);

  /// Frames located so far whose motion is a guess: that the robot stands still, or goes on as
  /// before where LiDAR odometry has lost its way and begun anew.
  std::uint64_t guessedFrames() const { return guessed_frames_; }

  const std::map<std::string, std::uint64_t>& warnings() const { return warnings_; }

 private:
  /// The base at one stamp and its motion from there on.
  struct Motion {
    Stamp stamp;
    Pose3 T_odom_base;
    SweepMotion motion;

    OdometryState at(Stamp other) const {
      return {T_odom_base * motion.at(secondsBetween(stamp, other)), std::nullopt};
    }
  };

  void estimateFromScan(SensorFrame& frame, std::span<const std::uint32_t> ignored);
  static void setOdometry(SensorFrame& frame, const std::optional<Motion>& motion);

  RobotOdometryParams params_;
  PlaneParams plane_params_;
  SweepDistortionParams distortion_;
  std::unique_ptr<ScanOdometry> scan_odometry_;
  std::optional<Pose3>
      T_level_odom_;  ///< LiDAR odometry starts with the base's axes, not with level ones
  /// Of the last scan that fitted.
  std::optional<Motion> scan_motion_;
  /// The log's odometry of a frame whose odometry has been predicted.
  std::optional<OdometryState> log_odometry_;
  bool predicted_ = false;
  bool restarted_ = false;  ///< LiDAR odometry, with the present scan
  std::uint64_t guessed_frames_ = 0;
  std::optional<Pose3> last_T_odom_base_;
  Stamp last_stamp_;
  std::optional<SweepMotion> motion_;  ///< during the present sweep
  std::optional<SweepMotion> mean_motion_;
  std::optional<OdometryState> keyframe_odometry_;
  /// LiDAR odometry: covariance accumulated since the last keyframe; empty when a scan failed in
  /// between.
  std::optional<Matrix6> scan_covariance_;
  std::optional<Matrix6> scan_step_covariance_;  ///< of the last scan's step; empty when it failed
  std::optional<OdometryState> last_odometry_;
  Matrix6 step_covariance_ = Matrix6::Identity();
  double path_m_ = 0.0, path_rad_ = 0.0;
  std::map<std::string, std::uint64_t> warnings_;
};

}  // namespace dynemo
