#include "dynemo/odometry/local_map_odometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dynemo/core/noise.h"
#include "dynemo/odometry/adaptive_threshold.h"
#include "dynemo/odometry/agitation.h"
#include "dynemo/odometry/point_times.h"
#include "dynemo/odometry/worker_pool.h"
#include "first_sweeps.h"
#include "relative_covariance.h"

namespace dynemo {
namespace {

/// Turns to either side that are tried for a scan that does not fit.
constexpr double kTurnStep_rad = 0.2;
constexpr int kTurnSteps = 4;
/// A wide match must reach this share of the inlier ratio that is usual.
constexpr double kUsualShare = 0.8;
constexpr double kUsualMemory = 0.9;

/// What is known about the base at one scan.
struct ScanState {
  Stamp stamp;
  double middle_s = 0.0;
  Pose3 T_odom_middle;
  Pose3 T_odom_base;
  /// Of the right tangent of T_odom_base, given the map.
  Matrix6 covariance = Matrix6::Zero();
  SweepMotion motion;
  /// Since the scan before.
  std::optional<BodyTwist> mean_twist;
  std::optional<Pose3> T_log_base;

  double middleAfter(const ScanState& earlier) const {
    return secondsBetween(earlier.stamp, stamp) + middle_s - earlier.middle_s;
  }
};

class LocalMapOdometry final : public ScanOdometry {
 public:
  explicit LocalMapOdometry(const OdometryParams& params)
      : params_(params.local_map),
        pool_(params.threads),
        map_(params.local_map.map),
        threshold_(params.local_map.initial_sigma_m, params.local_map.sigma_memory),
        agitation_(params.local_map.prediction.sigma_acceleration_m_s2,
                   params.local_map.prediction.sigma_angular_acceleration_rad_s2,
                   params.local_map.sigma_memory) {}

  Expected<OdometryEstimate, OdometryFailure> update(
      const Scan& scan, const std::optional<OdometryState>& rawlog_odometry,
      std::span<const std::uint32_t> ignored) override;
  bool measuresSweepMotion() const override { return params_.deskew; }

 private:
  struct Predicted {
    ScanState state;
    Matrix6 covariance;
    double dt_s;
    bool velocity_known;
  };

  Expected<OdometryEstimate, OdometryFailure> begin(const ScanState& now);
  Expected<OdometryEstimate, OdometryFailure> lose(OdometryFailure why, const Predicted& predicted);
  Predicted predict(const Scan& scan, const std::optional<Pose3>& T_log_base) const;
  bool timed(const Scan& scan) const {
    return params_.deskew && scan.cloud.time_offset_s.size() == scan.cloud.size();
  }
  RegistrationPrior priorOf(const Predicted& predicted) const;
  /// Where to look for a scan that does not fit at the prediction, most likely first.
  std::vector<Pose3> wideStarts(const Predicted& predicted) const;
  Expected<Registration, OdometryFailure> match(const SurfacePoints& surface,
                                                const Predicted& predicted);
  ScanState stateOf(const Predicted& predicted, const Registration& found) const;
  const ScanState& accept(ScanState now, const Predicted& predicted);
  void beginMap(const ScanState& now);
  void addToMap(ScanState& now);
  MappedSweep mapped(const ScanState& now) const {
    return {surface_, now.stamp, now.middle_s, now.T_odom_middle, now.motion};
  }
  void forgetFarCells(const Vector3& center);

  LocalMapParams params_;
  WorkerPool pool_;
  VoxelHashMap map_;
  AdaptiveThreshold threshold_;
  Agitation agitation_;
  std::optional<ScanState> last_;
  /// Until the map's beginning is settled.
  std::optional<FirstSweeps> first_;
  SurfacePoints surface_;
  int lost_scans_ = 0;
  double usual_inlier_ratio_ = 0.0;
  Vector3 last_forgetting_ = Vector3::Zero();
};

Expected<OdometryEstimate, OdometryFailure> LocalMapOdometry::update(
    const Scan& scan, const std::optional<OdometryState>& rawlog_odometry,
    std::span<const std::uint32_t> ignored) {
  if (last_ && scan.stamp <= last_->stamp) {
    return make_unexpected(OdometryFailure::kStampNotIncreasing);
  }
  std::optional<Pose3> T_log_base;
  if (rawlog_odometry && rawlog_odometry->T_odom_base.isFinite())
    T_log_base = rawlog_odometry->T_odom_base;

  const Predicted predicted = predict(scan, T_log_base);
  const std::span<const float> times_s =
      timed(scan) ? std::span<const float>(scan.cloud.time_offset_s) : std::span<const float>();
  surface_ = extractSurface(scan, times_s, predicted.state.middle_s, predicted.state.motion,
                            ignored, params_.surface, pool_);
  if (surface_.size() < static_cast<std::size_t>(params_.min_points)) {
    return make_unexpected(OdometryFailure::kTooFewPoints);
  }
  if (!last_) return begin(predicted.state);

  const auto found = match(surface_, predicted);
  if (!found) return lose(found.error(), predicted);

  const double ratio = found->diagnostics.inlier_ratio;
  usual_inlier_ratio_ = usual_inlier_ratio_ == 0.0
                            ? ratio
                            : kUsualMemory * usual_inlier_ratio_ + (1.0 - kUsualMemory) * ratio;
  const ScanState before = *last_;
  const ScanState& now = accept(stateOf(predicted, *found), predicted);
  OdometryEstimate estimate{now.stamp, now.T_odom_base,
                            before.T_odom_base.inverse() * now.T_odom_base};
  estimate.covariance = relativeCovariance(estimate.T_prev_base, before.covariance, now.covariance);
  estimate.motion = now.motion;
  estimate.diagnostics = found->diagnostics;
  return estimate;
}

/// The first sweep's motion is unknown: at rest until the next ones tell.
Expected<OdometryEstimate, OdometryFailure> LocalMapOdometry::begin(const ScanState& now) {
  beginMap(now);
  OdometryEstimate estimate{now.stamp, now.T_odom_base, Pose3()};
  estimate.motion = now.motion;
  estimate.diagnostics.points = surface_.size();
  estimate.diagnostics.inlier_ratio = 1.0;
  return estimate;
}

void LocalMapOdometry::beginMap(const ScanState& now) {
  map_.clear();
  insertSweep(mapped(now), map_);
  first_.reset();
  agitation_ =
      Agitation(params_.prediction.sigma_acceleration_m_s2,
                params_.prediction.sigma_angular_acceleration_rad_s2, params_.sigma_memory);
  if (surface_.timed()) {
    RegistrationPrior prior =
        priorOf({now, Matrix6::Identity(), params_.prediction.max_gap_s, true});
    prior.correspondence_m = 2.0 * params_.registration.min_correspondence_m;
    first_.emplace(params_.registration, prior, pool_);
    first_->add(mapped(now), map_);
  }
  last_ = now;
  lost_scans_ = 0;
}

/// A scan that does not fit leaves everything as it was; after too many the map is begun anew at
/// the prediction.
Expected<OdometryEstimate, OdometryFailure> LocalMapOdometry::lose(OdometryFailure why,
                                                                   const Predicted& predicted) {
  if (++lost_scans_ < params_.max_lost_scans) return make_unexpected(why);
  OdometryEstimate estimate{predicted.state.stamp, predicted.state.T_odom_base,
                            last_->T_odom_base.inverse() * predicted.state.T_odom_base};
  estimate.covariance = predicted.covariance;
  estimate.motion = predicted.state.motion;
  estimate.restarted = true;
  estimate.diagnostics.points = surface_.size();
  threshold_ = AdaptiveThreshold(params_.initial_sigma_m, params_.sigma_memory);
  beginMap(predicted.state);
  return estimate;
}

LocalMapOdometry::Predicted LocalMapOdometry::predict(
    const Scan& scan, const std::optional<Pose3>& T_log_base) const {
  Predicted p;
  p.state.stamp = scan.stamp;
  p.state.middle_s = timed(scan) ? middleOfSweep(scan.cloud) : 0.0;
  p.state.T_log_base = T_log_base;
  p.velocity_known = false;
  p.dt_s = 0.0;
  p.covariance = Matrix6::Zero();
  if (!last_) return p;
  p.dt_s = secondsBetween(last_->stamp, scan.stamp);
  const bool by_log =
      params_.prediction.source == Prediction::kRawlogOdometry && T_log_base && last_->T_log_base;
  p.velocity_known = by_log || p.dt_s <= params_.prediction.max_gap_s;
  if (by_log) {
    const Pose3 T_prev_base = last_->T_log_base->inverse() * *T_log_base;
    p.state.motion.twist = twistOf(T_prev_base, p.dt_s);
    p.state.T_odom_base = last_->T_odom_base * T_prev_base;
    p.state.T_odom_middle = p.state.T_odom_base * p.state.motion.at(p.state.middle_s);
    p.covariance = isotropicCovariance(params_.prediction.odometry_sigma_translation_m,
                                       params_.prediction.odometry_sigma_rotation_rad);
    return p;
  }
  const double middles_s = p.state.middleAfter(*last_);
  p.state.T_odom_middle = last_->T_odom_middle;
  if (p.velocity_known) {
    p.state.T_odom_middle = last_->T_odom_middle * last_->motion.at(middles_s);
    p.state.motion.twist = BodyTwist::fromVector(last_->motion.twist.vector() +
                                                 middles_s * last_->motion.acceleration.vector());
  }
  p.state.T_odom_base = p.state.T_odom_middle * p.state.motion.at(-p.state.middle_s);
  const double dt2 = p.dt_s * p.dt_s;
  p.covariance = isotropicCovariance(
      params_.prediction.sigma_acceleration_m_s2 * dt2,
      std::min(std::numbers::pi, params_.prediction.sigma_angular_acceleration_rad_s2 * dt2));
  return p;
}

RegistrationPrior LocalMapOdometry::priorOf(const Predicted& predicted) const {
  RegistrationPrior prior;
  prior.T_target_base = predicted.state.T_odom_middle;
  prior.covariance = predicted.covariance;
  prior.motion = predicted.state.motion;
  const double dt_s = std::min(predicted.dt_s, params_.prediction.max_gap_s);
  // Twice the usual acceleration, so that a change of pace is let through and raises the usual.
  const auto usual = [&](double rms, double largest) {
    return std::clamp(2.0 * rms, params_.prediction.calm_share * largest, largest);
  };
  prior.sigma_acceleration_m_s2 =
      usual(agitation_.linear_m_s2(), params_.prediction.sigma_acceleration_m_s2);
  prior.sigma_angular_acceleration_rad_s2 =
      usual(agitation_.angular_rad_s2(), params_.prediction.sigma_angular_acceleration_rad_s2);
  prior.sigma_vertical_m_s = params_.prediction.sigma_vertical_m_s;
  prior.sigma_linear_m_s = prior.sigma_acceleration_m_s2 * dt_s;
  prior.sigma_angular_rad_s = prior.sigma_angular_acceleration_rad_s2 * dt_s;
  prior.correspondence_m = std::min(params_.max_correspondence_m, 3.0 * threshold_.sigma_m());
  return prior;
}

/// From the prediction; where that fits badly with the widest search, also from where the robot was
/// and turned to either side, and then the best must fit about as well as scans usually do: a room
/// nearly fits itself at every quarter turn.
Expected<Registration, OdometryFailure> LocalMapOdometry::match(const SurfacePoints& surface,
                                                                const Predicted& predicted) {
  const auto fits = [&](const auto& r) {
    return r && r->diagnostics.inlier_ratio >= params_.min_inlier_ratio;
  };
  RegistrationPrior prior = priorOf(predicted);
  auto best = registerScan(surface, map_, prior, params_.registration, pool_);
  if (predicted.velocity_known && fits(best)) return best;
  prior.correspondence_m = params_.max_correspondence_m;
  prior.wide = true;
  const auto fitsAsUsual = [&](const auto& r) {
    return fits(r) && r->diagnostics.inlier_ratio >= kUsualShare * usual_inlier_ratio_;
  };
  for (const Pose3& start : wideStarts(predicted)) {
    prior.T_target_base = start;
    auto again = registerScan(surface, map_, prior, params_.registration, pool_);
    if (again && (!best || again->diagnostics.inlier_ratio > best->diagnostics.inlier_ratio))
      best = again;
    if (fitsAsUsual(best)) return best;
  }
  if (best) return make_unexpected(OdometryFailure::kNoOverlap);
  return best;
}

std::vector<Pose3> LocalMapOdometry::wideStarts(const Predicted& predicted) const {
  const Pose3& T_predicted = predicted.state.T_odom_middle;
  std::vector<Pose3> starts = {T_predicted, last_->T_odom_middle};
  for (int step = 1; step <= kTurnSteps; ++step) {
    for (const double side : {-1.0, 1.0}) {
      starts.push_back(T_predicted *
                       Pose3::fromYawPitchRoll(0, 0, 0, side * step * kTurnStep_rad, 0, 0));
    }
  }
  return starts;
}

ScanState LocalMapOdometry::stateOf(const Predicted& predicted, const Registration& found) const {
  ScanState now = predicted.state;
  now.T_odom_middle = found.T_target_base;
  now.motion = found.motion;
  if (!surface_.timed()) {
    now.motion = {
        twistOf(last_->T_odom_middle.inverse() * now.T_odom_middle, now.middleAfter(*last_)), {}};
  }
  const double tau_s = -now.middle_s;
  const Pose3 T_middle_base = now.motion.at(tau_s);
  now.T_odom_base = (now.T_odom_middle * T_middle_base).normalized();
  Eigen::Matrix<double, 6, 18> J;
  J << composeJacobianLeft(T_middle_base), tau_s * Matrix6::Identity(),
      0.5 * tau_s * tau_s * Matrix6::Identity();
  now.covariance = J * found.covariance * J.transpose();
  return now;
}

const ScanState& LocalMapOdometry::accept(ScanState now, const Predicted& predicted) {
  double range_sum_m = 0.0;
  for (const Eigen::Vector3f& p : surface_.points) range_sum_m += static_cast<double>(p.norm());
  const double dt_s = now.middleAfter(*last_);
  now.mean_twist = twistOf(last_->T_odom_middle.inverse() * now.T_odom_middle, dt_s);
  if (last_->mean_twist) agitation_.add(*last_->mean_twist, *now.mean_twist, dt_s);
  const Vector6 error = local(predicted.state.T_odom_middle, now.T_odom_middle);
  threshold_.add(error.head<3>().norm(), error.tail<3>().norm(),
                 range_sum_m / static_cast<double>(surface_.size()));
  addToMap(now);
  forgetFarCells(now.T_odom_middle.t);
  last_ = now;
  lost_scans_ = 0;
  return *last_;
}

/// The beginning of the map may be built again, which moves the newest sweep too.
void LocalMapOdometry::addToMap(ScanState& now) {
  insertSweep(mapped(now), map_);
  if (!first_) return;
  if (!surface_.timed()) {
    first_.reset();
    return;
  }
  if (first_->add(mapped(now), map_)) {
    now.T_odom_middle = first_->last().T_odom_middle;
    now.motion = first_->last().motion;
    now.T_odom_base = now.T_odom_middle * now.motion.at(-now.middle_s);
  }
  if (first_->complete()) first_.reset();
}

void LocalMapOdometry::forgetFarCells(const Vector3& center) {
  if (!params_.map_radius_m || (center - last_forgetting_).norm() < 0.1 * *params_.map_radius_m)
    return;
  map_.removeFartherThan(center.cast<float>(), *params_.map_radius_m);
  last_forgetting_ = center;
}

}  // namespace

std::unique_ptr<ScanOdometry> makeLocalMapOdometry(const OdometryParams& params) {
  return std::make_unique<LocalMapOdometry>(params);
}

}  // namespace dynemo
