#include "dynemo/odometry/local_map_odometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynemo/core/noise.h"
#include "dynemo/odometry/adaptive_threshold.h"
#include "dynemo/odometry/worker_pool.h"
#include "relative_covariance.h"

namespace dynemo {
namespace {

/// Rounds of alternating registration of the first two sweeps; the second changes poses by less
/// than a millimetre.
constexpr int kFirstSweepRounds = 2;

/// One sweep, its point times and their middle.
struct Sweep {
  Scan scan;
  std::vector<float> times_s;
  double middle_s = 0.0;
  PointIndices ignored;
};

/// What is known about the base at one scan.
struct ScanState {
  Stamp stamp;
  double middle_s = 0.0;
  Pose3 T_odom_middle;
  Pose3 T_odom_base;
  /// Of the right tangent of T_odom_base, given the map.
  Matrix6 covariance = Matrix6::Zero();
  BodyTwist twist;
  std::optional<Pose3> T_log_base;

  double middleAfter(const ScanState& earlier) const {
    return secondsBetween(earlier.stamp, stamp) + middle_s - earlier.middle_s;
  }
};

class LocalMapOdometry final : public ScanOdometry {
 public:
  explicit LocalMapOdometry(const OdometryParams& params)
      : point_times_(params.point_times),
        params_(params.local_map),
        pool_(params.threads),
        map_(params.local_map.map),
        threshold_(params.local_map.initial_sigma_m, params.local_map.sigma_memory) {}

  Expected<OdometryEstimate, OdometryFailure> update(
      const Scan& scan, const std::optional<OdometryState>& rawlog_odometry,
      std::span<const std::uint32_t> ignored) override;

 private:
  struct Predicted {
    ScanState state;
    Matrix6 covariance;
    double dt_s;
    bool velocity_known;
  };

  Expected<OdometryEstimate, OdometryFailure> begin(const ScanState& now);
  Expected<OdometryEstimate, OdometryFailure> lose(OdometryFailure why, const Predicted& predicted);
  Predicted predict(const Sweep& sweep, const std::optional<Pose3>& T_log_base) const;
  SurfacePoints surfaceOf(const Sweep& sweep, const BodyTwist& twist);
  RegistrationPrior priorOf(const Predicted& predicted) const;
  Expected<Registration, OdometryFailure> match(const SurfacePoints& surface,
                                                const Predicted& predicted);
  Expected<Registration, OdometryFailure> untangleFirstSweeps(const Predicted& predicted,
                                                              Registration found);
  void insert(const SurfacePoints& surface, const Pose3& T_odom_middle, const BodyTwist& twist);
  ScanState stateOf(const Predicted& predicted, const Registration& found) const;
  void accept(const ScanState& now, const Predicted& predicted);
  void forgetFarCells(const Vector3& center);

  PointTimeParams point_times_;
  LocalMapParams params_;
  WorkerPool pool_;
  VoxelHashMap map_;
  AdaptiveThreshold threshold_;
  std::optional<ScanState> last_;
  /// The sweep that began the map, until its motion is known.
  std::optional<Sweep> first_;
  Sweep sweep_;
  SurfacePoints surface_;
  int lost_scans_ = 0;
  Vector3 last_forgetting_ = Vector3::Zero();
};

Expected<OdometryEstimate, OdometryFailure> LocalMapOdometry::update(
    const Scan& scan, const std::optional<OdometryState>& rawlog_odometry,
    std::span<const std::uint32_t> ignored) {
  if (last_ && scan.stamp <= last_->stamp) {
    return make_unexpected(OdometryFailure::kStampNotIncreasing);
  }
  sweep_ = {scan, pointTimes(scan.cloud, point_times_), 0.0, {ignored.begin(), ignored.end()}};
  sweep_.middle_s = middleOfSweep(sweep_.times_s);
  std::optional<Pose3> T_log_base;
  if (rawlog_odometry && rawlog_odometry->T_odom_base.isFinite())
    T_log_base = rawlog_odometry->T_odom_base;

  const Predicted predicted = predict(sweep_, T_log_base);
  surface_ = surfaceOf(sweep_, predicted.state.twist);
  if (surface_.size() < static_cast<std::size_t>(params_.min_points)) {
    return make_unexpected(OdometryFailure::kTooFewPoints);
  }
  if (!last_) return begin(predicted.state);

  auto found = match(surface_, predicted);
  if (found && first_ && surface_.timed()) found = untangleFirstSweeps(predicted, *found);
  if (!found) return lose(found.error(), predicted);
  first_.reset();

  const ScanState now = stateOf(predicted, *found);
  OdometryEstimate estimate{now.stamp, now.T_odom_base,
                            last_->T_odom_base.inverse() * now.T_odom_base};
  estimate.covariance = relativeCovariance(estimate.T_prev_base, last_->covariance, now.covariance);
  estimate.twist = now.twist;
  estimate.diagnostics = found->diagnostics;
  accept(now, predicted);
  return estimate;
}

/// The first sweep's motion is unknown: at rest until the second sweep tells.
Expected<OdometryEstimate, OdometryFailure> LocalMapOdometry::begin(const ScanState& now) {
  insert(surface_, now.T_odom_middle, now.twist);
  first_ = std::move(sweep_);
  OdometryEstimate estimate{now.stamp, now.T_odom_base, Pose3()};
  estimate.twist = now.twist;
  estimate.diagnostics.points = surface_.size();
  estimate.diagnostics.inlier_ratio = 1.0;
  last_ = now;
  return estimate;
}

/// A scan that does not fit leaves everything as it was; after too many the map is begun anew at
/// the prediction.
Expected<OdometryEstimate, OdometryFailure> LocalMapOdometry::lose(OdometryFailure why,
                                                                   const Predicted& predicted) {
  if (++lost_scans_ < params_.max_lost_scans) return make_unexpected(why);
  OdometryEstimate estimate{predicted.state.stamp, predicted.state.T_odom_base,
                            last_->T_odom_base.inverse() * predicted.state.T_odom_base};
  estimate.covariance = predicted.covariance;
  estimate.twist = predicted.state.twist;
  estimate.restarted = true;
  estimate.diagnostics.points = surface_.size();
  map_.clear();
  first_.reset();
  threshold_ = AdaptiveThreshold(params_.initial_sigma_m, params_.sigma_memory);
  insert(surface_, predicted.state.T_odom_middle, predicted.state.twist);
  last_ = predicted.state;
  lost_scans_ = 0;
  return estimate;
}

LocalMapOdometry::Predicted LocalMapOdometry::predict(
    const Sweep& sweep, const std::optional<Pose3>& T_log_base) const {
  Predicted p;
  p.state.stamp = sweep.scan.stamp;
  p.state.middle_s = sweep.middle_s;
  p.state.T_log_base = T_log_base;
  p.velocity_known = false;
  p.dt_s = 0.0;
  p.covariance = Matrix6::Zero();
  if (!last_) return p;
  p.dt_s = secondsBetween(last_->stamp, sweep.scan.stamp);
  const bool by_log =
      params_.prediction.source == Prediction::kRawlogOdometry && T_log_base && last_->T_log_base;
  p.velocity_known = by_log || p.dt_s <= params_.prediction.max_gap_s;
  if (by_log) {
    const Pose3 T_prev_base = last_->T_log_base->inverse() * *T_log_base;
    p.state.twist = twistOf(T_prev_base, p.dt_s);
    p.state.T_odom_base = last_->T_odom_base * T_prev_base;
    p.state.T_odom_middle = p.state.T_odom_base * moved(p.state.twist, p.state.middle_s);
    p.covariance = isotropicCovariance(params_.prediction.odometry_sigma_translation_m,
                                       params_.prediction.odometry_sigma_rotation_rad);
    return p;
  }
  if (p.velocity_known) p.state.twist = last_->twist;
  p.state.T_odom_middle = last_->T_odom_middle * moved(p.state.twist, p.state.middleAfter(*last_));
  p.state.T_odom_base = p.state.T_odom_middle * moved(p.state.twist, -p.state.middle_s);
  const double dt2 = p.dt_s * p.dt_s;
  p.covariance = isotropicCovariance(
      params_.prediction.sigma_acceleration_m_s2 * dt2,
      std::min(std::numbers::pi, params_.prediction.sigma_angular_acceleration_rad_s2 * dt2));
  return p;
}

SurfacePoints LocalMapOdometry::surfaceOf(const Sweep& sweep, const BodyTwist& twist) {
  return extractSurface(sweep.scan, sweep.times_s, sweep.middle_s, twist, sweep.ignored,
                        params_.surface, pool_);
}

RegistrationPrior LocalMapOdometry::priorOf(const Predicted& predicted) const {
  RegistrationPrior prior;
  prior.T_target_base = predicted.state.T_odom_middle;
  prior.covariance = predicted.covariance;
  prior.twist = predicted.state.twist;
  const double dt_s = std::min(predicted.dt_s, params_.prediction.max_gap_s);
  prior.sigma_linear_m_s = params_.prediction.sigma_acceleration_m_s2 * dt_s;
  prior.sigma_angular_rad_s = params_.prediction.sigma_angular_acceleration_rad_s2 * dt_s;
  prior.correspondence_m = std::min(params_.max_correspondence_m, 3.0 * threshold_.sigma_m());
  return prior;
}

/// From the prediction; where that fits badly again with the widest search, then from where the
/// robot was.
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
  for (const Pose3& start : {predicted.state.T_odom_middle, last_->T_odom_middle}) {
    prior.T_target_base = start;
    auto again = registerScan(surface, map_, prior, params_.registration, pool_);
    if (again && (!best || again->diagnostics.inlier_ratio > best->diagnostics.inlier_ratio))
      best = again;
    if (fits(best)) return best;
  }
  if (best) return make_unexpected(OdometryFailure::kNoOverlap);
  return best;
}

/// Registers the first sweep to the second one and back, each with its own twist. The odometry
/// frame stays where the base was at the first stamp.
Expected<Registration, OdometryFailure> LocalMapOdometry::untangleFirstSweeps(
    const Predicted& predicted, Registration found) {
  Predicted earlier = predicted;
  earlier.state.T_odom_middle = last_->T_odom_middle;
  earlier.state.twist = found.twist;
  for (int round = 0; round < kFirstSweepRounds; ++round) {
    map_.clear();
    surface_ = surfaceOf(sweep_, found.twist);
    insert(surface_, found.T_target_base, found.twist);
    SurfacePoints first_surface = surfaceOf(*first_, earlier.state.twist);
    const auto first =
        registerScan(first_surface, map_, priorOf(earlier), params_.registration, pool_);
    if (!first) return first;
    earlier.state.twist = first->twist;
    earlier.state.T_odom_middle = moved(first->twist, first_->middle_s);
    first_surface = surfaceOf(*first_, first->twist);
    map_.clear();
    insert(first_surface, earlier.state.T_odom_middle, first->twist);

    Predicted later = predicted;
    later.state.twist = found.twist;
    later.state.T_odom_middle =
        earlier.state.T_odom_middle * first->T_target_base.inverse() * found.T_target_base;
    const auto again = registerScan(surface_, map_, priorOf(later), params_.registration, pool_);
    if (!again) return again;
    found = *again;
  }
  last_->twist = earlier.state.twist;
  last_->T_odom_middle = earlier.state.T_odom_middle;
  return found;
}

void LocalMapOdometry::insert(const SurfacePoints& surface, const Pose3& T_odom_middle,
                              const BodyTwist& twist) {
  const Eigen::Vector3f linear = twist.linear_m_s.cast<float>();
  const Eigen::Vector3f angular = twist.angular_rad_s.cast<float>();
  const Eigen::Matrix3f R = T_odom_middle.R.cast<float>();
  for (std::size_t i = 0; i < surface.size(); ++i) {
    Eigen::Vector3f p = surface.points[i];
    if (surface.timed()) p = carriedToReference<float>(linear, angular, surface.time_s[i], p);
    map_.insert((T_odom_middle * p.cast<double>()).cast<float>(), R * surface.normals[i]);
  }
}

ScanState LocalMapOdometry::stateOf(const Predicted& predicted, const Registration& found) const {
  ScanState now = predicted.state;
  now.T_odom_middle = found.T_target_base;
  now.twist = surface_.timed() ? found.twist
                               : twistOf(last_->T_odom_middle.inverse() * now.T_odom_middle,
                                         now.middleAfter(*last_));
  const Pose3 T_middle_base = moved(now.twist, -now.middle_s);
  now.T_odom_base = (now.T_odom_middle * T_middle_base).normalized();
  Eigen::Matrix<double, 6, 12> J;
  J << composeJacobianLeft(T_middle_base), -now.middle_s * Matrix6::Identity();
  now.covariance = J * found.covariance * J.transpose();
  return now;
}

void LocalMapOdometry::accept(const ScanState& now, const Predicted& predicted) {
  double range_sum_m = 0.0;
  for (const Eigen::Vector3f& p : surface_.points) range_sum_m += static_cast<double>(p.norm());
  const Vector6 error = local(predicted.state.T_odom_middle, now.T_odom_middle);
  threshold_.add(error.head<3>().norm(), error.tail<3>().norm(),
                 range_sum_m / static_cast<double>(surface_.size()));
  insert(surface_, now.T_odom_middle, now.twist);
  forgetFarCells(now.T_odom_middle.t);
  last_ = now;
  lost_scans_ = 0;
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
