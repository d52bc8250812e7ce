#include "odometry_trial.h"

#include <algorithm>

namespace dynemo {
namespace {

/// Long enough for a lost map to be begun anew several times.
constexpr std::uint64_t kStretch = 25;

}  // namespace

OdometryTrial::OdometryTrial(const InspectionParams& params, bool rawlog_odometry,
                             std::uint64_t scans)
    : params_(params.odometry),
      rawlog_odometry_(rawlog_odometry),
      active_(usesLidarOdometry(params.odometry, rawlog_odometry) && params.odometry_scans > 0) {
  RobotTracker(params_, rawlog_odometry);  // which throws as dynemo-slam does
  const auto most = static_cast<std::uint64_t>(std::max(0, params.odometry_scans));
  const std::uint64_t stretches = std::max<std::uint64_t>(1, most / kStretch);
  const bool all = scans <= most;
  spacing_ = all ? std::max<std::uint64_t>(1, scans) : std::max(kStretch, scans / stretches);
  stretch_ = all ? spacing_ : std::min(most, kStretch);
}

void OdometryTrial::add(SensorFrame& frame) {
  if (!active_ || !frame.scan) return;
  const std::uint64_t place = index_++ % spacing_;
  if (place == 0) beginStretch();
  if (place >= stretch_) return;
  tracker_->estimate(frame);
  // The first scan of a map has nothing to fit to.
  if (place == 0) return;
  ++result_.scans;
  if (frame.odometry) ++result_.followed;
}

void OdometryTrial::beginStretch() {
  endStretch();
  tracker_ = std::make_unique<RobotTracker>(params_, rawlog_odometry_);
}

void OdometryTrial::endStretch() {
  if (!tracker_) return;
  for (const auto& [what, count] : tracker_->warnings()) result_.warnings[what] += count;
  tracker_.reset();
}

std::optional<OdometryTrialResult> OdometryTrial::result() {
  endStretch();
  return result_.scans > 0 ? std::optional(result_) : std::nullopt;
}

}  // namespace dynemo
