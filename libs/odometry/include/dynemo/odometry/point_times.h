// When each point of a sweep was measured.
#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/point_cloud.h"

namespace dynemo {

enum class PointTimeSource : std::uint8_t { kNone, kObservation, kAzimuth };

struct PointTimeParams {
  PointTimeSource source = PointTimeSource::kObservation;
  double sweep_period_s = 0.1;
  double sweep_start_rad = -std::numbers::pi;
  bool clockwise = false;
};
void fields(FieldVisitor& v, PointTimeParams& p);

/// Seconds after the scan's stamp per point: those of the observation, or from each point's azimuth
/// in the sensor frame for a sensor that turns at a constant rate from `sweep_start_rad` at the
/// stamp. Empty when the points have no times, which means a scan of one instant.
std::vector<float> pointTimes(const PointCloud& cloud, const PointTimeParams& params);

/// The instant halfway between the first and the last point, seconds after the stamp; 0 without
/// times.
double middleOfSweep(const std::vector<float>& times_s);

}  // namespace dynemo
