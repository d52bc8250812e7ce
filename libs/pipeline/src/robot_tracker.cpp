#include "dynemo/pipeline/robot_tracker.h"

#include "dynemo/core/noise.h"
#include "dynemo/mapping/ground_plane.h"
#include "dynemo/mapping/localize.h"
#include "dynemo/odometry/deskew.h"
#include "dynemo/odometry/point_times.h"

namespace dynemo {
namespace {

/// The motion between two frames goes on; nothing where they are too far apart to tell.
std::optional<SweepMotion> steadyMotion(const Pose3& T_last_base, double dt_s) {
  constexpr double kMaxGap_s = 1.0;
  if (dt_s <= 0.0 || dt_s > kMaxGap_s) return std::nullopt;
  return SweepMotion{twistOf(T_last_base, dt_s), {}};
}

/// What lets odometry be as wrong as it must be if the robot cannot have moved as it says. A crowd
/// that walks along drags a scan with it, and the Hessian of a slip is as large as any other.
Matrix6 implausibility(const SweepMotion& before, const Pose3& T_prev_base, double dt_s) {
  constexpr double kMaxAcceleration_m_s2 = 5.0, kMaxAcceleration_rad_s2 = 10.0;
  const Vector6 surprise = local(before.at(dt_s), T_prev_base);
  const auto excess = [&](const Vector3& d, double acceleration) -> Vector3 {
    const double possible = acceleration * dt_s * dt_s;
    return d.norm() > possible ? Vector3(d * (1.0 - possible / d.norm())) : Vector3::Zero();
  };
  const Vector3 translation = excess(surprise.head<3>(), kMaxAcceleration_m_s2);
  const Vector3 rotation = excess(surprise.tail<3>(), kMaxAcceleration_rad_s2);
  Matrix6 covariance = Matrix6::Zero();
  covariance.topLeftCorner<3, 3>() = translation * translation.transpose();
  covariance.bottomRightCorner<3, 3>() = rotation * rotation.transpose();
  return covariance;
}

}  // namespace

bool usesLidarOdometry(const RobotOdometryParams& params, bool rawlog_odometry) {
  return params.source == OdometrySource::kLidar ||
         (params.source == OdometrySource::kAuto && !rawlog_odometry);
}

RobotTracker::RobotTracker(const RobotOdometryParams& params, bool rawlog_odometry,
                           const PlaneParams& planes, const SweepDistortionParams& distortion)
    : params_(params), plane_params_(planes), distortion_(distortion) {
  if (params.source == OdometrySource::kRawlog && !rawlog_odometry) {
    throw ConfigError(
        "odometry.source: rawlog: the rawlog carries no odometry that can be used; use auto or "
        "lidar");
  }
  if (usesLidarOdometry(params, rawlog_odometry)) {
    scan_odometry_ = scanOdometries().make(params.lidar.method, params.lidar);
  }
}

RobotTracker::~RobotTracker() = default;

void RobotTracker::useCache(FrontEndCache& cache) {
  if (scan_odometry_) scan_odometry_ = cache.wrap(std::move(scan_odometry_));
}

void RobotTracker::predict(SensorFrame& frame) {
  if (!scan_odometry_ || !frame.scan) return;
  log_odometry_ = frame.odometry;
  predicted_ = true;
  setOdometry(frame, scan_motion_);
}

void RobotTracker::estimate(SensorFrame& frame, std::span<const std::uint32_t> ignored) {
  restarted_ = false;
  if (scan_odometry_ && frame.scan) estimateFromScan(frame, ignored);
}

void RobotTracker::setOdometry(SensorFrame& frame, const std::optional<Motion>& motion) {
  const auto at = [&](Stamp stamp) {
    return motion ? std::optional(motion->at(stamp)) : std::nullopt;
  };
  frame.odometry = at(frame.stamp);
  for (CameraImage& image : frame.images) image.odometry = at(image.stamp);
  for (ExternalDetection& detection : frame.detections) detection.odometry = at(detection.stamp);
}

void RobotTracker::estimateFromScan(SensorFrame& frame, std::span<const std::uint32_t> ignored) {
  if (!T_level_odom_) {
    const auto planes = planeExtractors().make(plane_params_.extractor, plane_params_);
    const auto ground = findGround(planes->extract(*frame.scan), Matrix3::Identity());
    T_level_odom_ = ground ? Pose3(levelling(*ground), Vector3::Zero()) : Pose3();
  }
  motion_.reset();
  const auto log_odometry = predicted_ ? log_odometry_ : frame.odometry;
  predicted_ = false;
  const auto estimate = scan_odometry_->update(*frame.scan, log_odometry, ignored);
  if (!estimate) {
    setOdometry(frame, std::nullopt);
    ++warnings_["LiDAR odometry: " + toString(estimate.error())];
    scan_covariance_.reset();
    scan_step_covariance_.reset();
    return;
  }
  restarted_ = estimate->restarted;
  if (restarted_) ++warnings_["LiDAR odometry: lost its way and began anew"];
  scan_step_covariance_ = estimate->covariance;
  const bool velocity_known = scan_motion_ && !scan_motion_->motion.twist.vector().isZero(0.0);
  if (velocity_known) {
    *scan_step_covariance_ += implausibility(scan_motion_->motion, estimate->T_prev_base,
                                             secondsBetween(scan_motion_->stamp, frame.stamp));
  }
  motion_ = estimate->motion;
  scan_motion_ = Motion{frame.stamp, *T_level_odom_ * estimate->T_odom_base, estimate->motion};
  setOdometry(frame, scan_motion_);
  if (!scan_odometry_->measuresSweepMotion()) {
    const double sweep_s = 2.0 * middleOfSweep(frame.scan->cloud);
    *scan_step_covariance_ +=
        distortionCovariance(sweep_s * estimate->motion.twist.vector(), distortion_);
  }
  if (scan_covariance_) {
    const Matrix6 A = composeJacobianLeft(estimate->T_prev_base);
    scan_covariance_ = A * *scan_covariance_ * A.transpose() + *scan_step_covariance_;
  }
}

Pose3 RobotTracker::locate(const SensorFrame& frame,
                           const std::vector<EntityObservation>& observations,
                           const CSceneGraph& graph) {
  Pose3 T_odom_base = last_T_odom_base_.value_or(Pose3());
  if (frame.odometry) {
    T_odom_base = frame.odometry->T_odom_base;
    if (restarted_) ++guessed_frames_;
  } else {
    ++warnings_["frame without odometry"];
    if (const auto T_map_base = localizeFromEntities(observations, graph)) {
      T_odom_base = graph.T_map_odom.inverse() * *T_map_base;
    } else if (last_T_odom_base_) {
      ++guessed_frames_;
    }
  }
  if (last_T_odom_base_) {
    const Pose3 T_last_base = last_T_odom_base_->inverse() * T_odom_base;
    const double step_m = T_last_base.t.norm(), step_rad = rotationAngle(T_last_base);
    path_m_ += step_m;
    path_rad_ += step_rad;
    const OdometryNoiseParams& noise = params_.noise;
    step_covariance_ =
        scan_odometry_ && scan_step_covariance_
            ? floorCovariance(*scan_step_covariance_, noise.lidar_min_sigma_m,
                              noise.lidar_min_sigma_rad)
            : relativeOdometryCovariance(last_odometry_, frame.odometry, step_m, step_rad, noise);
    mean_motion_ = steadyMotion(T_last_base, secondsBetween(last_stamp_, frame.stamp));
    if (!scan_odometry_) motion_ = mean_motion_;
  }
  last_T_odom_base_ = T_odom_base;
  last_odometry_ = frame.odometry;
  last_stamp_ = frame.stamp;
  return T_odom_base;
}

bool RobotTracker::knowsSweepMotion() const {
  return motion_ && scan_odometry_ && scan_odometry_->measuresSweepMotion();
}

Matrix6 RobotTracker::covarianceSinceKeyframe(const SensorFrame& frame,
                                              const CSceneGraph& graph) const {
  const OdometryNoiseParams& noise = params_.noise;
  if (noise.source == OdometryNoiseSource::kFitness && frame.scan && frame.odometry &&
      !graph.keyframes().empty()) {
    const CNodeKeyframe& last = *graph.keyframes().back();
    if (last.scan) {
      const Pose3 T_last_base = last.T_odom_base.inverse() * frame.odometry->T_odom_base;
      return fitnessCovariance(scanFitness(*last.scan, *frame.scan, T_last_base), noise);
    }
  }
  if (noise.source == OdometryNoiseSource::kRecorded && scan_odometry_ && scan_covariance_ &&
      frame.odometry) {
    return floorCovariance(*scan_covariance_, noise.lidar_min_sigma_m, noise.lidar_min_sigma_rad);
  }
  return relativeOdometryCovariance(keyframe_odometry_, frame.odometry, path_m_, path_rad_, noise);
}

void RobotTracker::keyframeMade(const SensorFrame& frame) {
  keyframe_odometry_ = frame.odometry;
  scan_covariance_ = Matrix6::Zero();
  path_m_ = path_rad_ = 0.0;
}

}  // namespace dynemo
