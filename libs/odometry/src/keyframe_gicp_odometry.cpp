#include "dynemo/odometry/keyframe_gicp_odometry.h"

#include "dynemo/odometry/kd_tree_target.h"
#include "dynemo/odometry/point_times.h"
#include "dynemo/odometry/worker_pool.h"
#include "relative_covariance.h"

namespace dynemo {
namespace {

// Scans are registered as they are, without deskewing, which finds the base at about the middle of
// the sweep. Poses of keyframes and T_keyframe_last_ are those; estimates are carried back to the
// stamp.
struct Keyframe {
  Pose3 T_odom_keyframe;
  std::unique_ptr<KdTreeTarget> target;
};

class KeyframeGicpOdometry final : public ScanOdometry {
 public:
  explicit KeyframeGicpOdometry(const OdometryParams& params)
      : params_(params.keyframe_gicp), pool_(params.threads) {}

  Expected<OdometryEstimate, OdometryFailure> update(
      const Scan& scan, const std::optional<OdometryState>&,
      std::span<const std::uint32_t> ignored) override;

 private:
  bool farFromKeyframe(const Pose3& T_keyframe_base) const {
    return T_keyframe_base.t.norm() > params_.keyframe_translation_m ||
           rotationAngle(T_keyframe_base) > params_.keyframe_rotation_rad;
  }
  OdometryEstimate estimateOf(Stamp stamp, double middle_s, const Registration& found);

  KeyframeGicpParams params_;
  WorkerPool pool_;
  std::optional<Keyframe> keyframe_;
  Stamp last_stamp_;
  Pose3 T_odom_last_;
  Pose3 T_keyframe_last_;
  Matrix6 last_covariance_ = Matrix6::Zero();
};

Expected<OdometryEstimate, OdometryFailure> KeyframeGicpOdometry::update(
    const Scan& scan, const std::optional<OdometryState>&, std::span<const std::uint32_t> ignored) {
  if (keyframe_ && scan.stamp <= last_stamp_) {
    return make_unexpected(OdometryFailure::kStampNotIncreasing);
  }
  SurfacePoints surface = extractSurface(scan, {}, 0.0, {}, ignored, params_.surface, pool_);
  if (surface.size() < static_cast<std::size_t>(params_.min_points)) {
    return make_unexpected(OdometryFailure::kTooFewPoints);
  }
  if (!keyframe_) {
    OdometryEstimate first{scan.stamp, Pose3(), Pose3()};
    first.diagnostics.points = surface.size();
    first.diagnostics.inlier_ratio = 1.0;
    keyframe_ = Keyframe{Pose3(), std::make_unique<KdTreeTarget>(std::move(surface))};
    last_stamp_ = scan.stamp;
    return first;
  }
  RegistrationPrior prior;
  prior.T_target_base = T_keyframe_last_;
  prior.correspondence_m = params_.correspondence_m;
  const auto found = registerScan(surface, *keyframe_->target, prior, params_.registration, pool_);
  if (!found) return make_unexpected(found.error());
  const OdometryEstimate estimate = estimateOf(scan.stamp, middleOfSweep(scan.cloud), *found);
  if (farFromKeyframe(found->T_target_base)) {
    keyframe_ = Keyframe{(keyframe_->T_odom_keyframe * found->T_target_base).normalized(),
                         std::make_unique<KdTreeTarget>(std::move(surface))};
    T_keyframe_last_ = Pose3();
    last_covariance_.setZero();
  }
  return estimate;
}

OdometryEstimate KeyframeGicpOdometry::estimateOf(Stamp stamp, double middle_s,
                                                  const Registration& found) {
  const Pose3 T_last_now = T_keyframe_last_.inverse() * found.T_target_base;
  OdometryEstimate estimate;
  estimate.stamp = stamp;
  estimate.motion.twist = twistOf(T_last_now, secondsBetween(last_stamp_, stamp));
  const Pose3 T_middle_base = estimate.motion.at(-middle_s);
  estimate.T_odom_base =
      (keyframe_->T_odom_keyframe * found.T_target_base * T_middle_base).normalized();
  estimate.T_prev_base = T_odom_last_.inverse() * estimate.T_odom_base;
  const Matrix6 covariance = found.covariance.topLeftCorner<6, 6>();
  estimate.covariance = relativeCovariance(T_last_now, last_covariance_, covariance);
  estimate.diagnostics = found.diagnostics;
  T_odom_last_ = estimate.T_odom_base;
  T_keyframe_last_ = found.T_target_base;
  last_covariance_ = covariance;
  last_stamp_ = stamp;
  return estimate;
}

}  // namespace

std::unique_ptr<ScanOdometry> makeKeyframeGicpOdometry(const OdometryParams& params) {
  return std::make_unique<KeyframeGicpOdometry>(params);
}

}  // namespace dynemo
