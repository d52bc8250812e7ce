// The odometry of the last moments, interpolated to any stamp among them.
#pragma once

#include <deque>
#include <optional>

#include "dynemo/ingest/ingest_params.h"
#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

class OdometryBuffer {
 public:
  explicit OdometryBuffer(const OdometrySensorParams& params) : params_(params) {}

  /// Stamps must increase; false, without effect, when this one does not.
  bool push(Stamp stamp, const OdometryState& state);
  /// Forgets what no query at or after `stamp` can need.
  void forgetBefore(Stamp stamp);

  /// Between two samples at most max_gap_s apart: interpolated on SE(3), covariance linearly.
  /// Otherwise continued from the nearest sample at constant velocity, by at most
  /// max_extrapolation_s. Otherwise nothing.
  std::optional<OdometryState> at(Stamp stamp) const;

  bool empty() const { return samples_.empty(); }
  Stamp last() const { return samples_.back().stamp; }
  std::size_t size() const { return samples_.size(); }

 private:
  struct Sample {
    Stamp stamp;
    OdometryState state;
  };
  std::optional<OdometryState> extrapolate(std::size_t from, std::size_t towards,
                                           Stamp stamp) const;

  OdometrySensorParams params_;
  std::deque<Sample> samples_;
};

}  // namespace dynemo
