#include "dynemo/ingest/odometry_buffer.h"

#include <algorithm>

namespace dynemo {

bool OdometryBuffer::push(Stamp stamp, const OdometryState& state) {
  if (!samples_.empty() && stamp <= samples_.back().stamp) return false;
  samples_.push_back({stamp, state});
  return true;
}

void OdometryBuffer::forgetBefore(Stamp stamp) {
  // Two samples at or before the stamp stay: one to interpolate from, one more for the velocity.
  while (samples_.size() > 2 && samples_[2].stamp <= stamp) samples_.pop_front();
}

std::optional<OdometryState> OdometryBuffer::at(Stamp stamp) const {
  const auto after =
      std::lower_bound(samples_.begin(), samples_.end(), stamp,
                       [](const Sample& sample, Stamp s) { return sample.stamp < s; });
  if (after != samples_.end() && after->stamp == stamp) return after->state;
  const auto i = static_cast<std::size_t>(after - samples_.begin());
  if (samples_.empty()) return std::nullopt;
  if (i == 0) return extrapolate(0, std::min<std::size_t>(1, samples_.size() - 1), stamp);
  if (i == samples_.size()) return extrapolate(i - 1, i < 2 ? 0 : i - 2, stamp);

  const Sample &a = samples_[i - 1], &b = samples_[i];
  const double gap_s = secondsBetween(a.stamp, b.stamp);
  const double from_a_s = secondsBetween(a.stamp, stamp);
  if (gap_s > params_.max_gap_s) {
    const bool nearer_a = from_a_s <= gap_s - from_a_s;
    if (nearer_a) return extrapolate(i - 1, i < 2 ? i - 1 : i - 2, stamp);
    return extrapolate(i, std::min(i + 1, samples_.size() - 1), stamp);
  }
  const double s = from_a_s / gap_s;
  OdometryState state;
  state.T_odom_base = interpolate(a.state.T_odom_base, b.state.T_odom_base, s);
  if (a.state.accumulated_covariance && b.state.accumulated_covariance)
    state.accumulated_covariance =
        (1.0 - s) * *a.state.accumulated_covariance + s * *b.state.accumulated_covariance;
  return state;
}

std::optional<OdometryState> OdometryBuffer::extrapolate(std::size_t from, std::size_t other,
                                                         Stamp stamp) const {
  const Sample &near = samples_[from], &far = samples_[other];
  const double ahead_s = secondsBetween(near.stamp, stamp);
  if (std::abs(ahead_s) > params_.max_extrapolation_s) return std::nullopt;
  OdometryState state = near.state;
  const double baseline_s = secondsBetween(far.stamp, near.stamp);
  // Without a second sample close by the velocity is unknown: standing still is the best guess.
  if (baseline_s == 0.0 || std::abs(baseline_s) > params_.max_gap_s) return state;
  const Vector6 step = local(far.state.T_odom_base, near.state.T_odom_base) / baseline_s * ahead_s;
  state.T_odom_base = near.state.T_odom_base.retract(step);
  return state;
}

}  // namespace dynemo
