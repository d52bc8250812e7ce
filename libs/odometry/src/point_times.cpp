#include "dynemo/odometry/point_times.h"

#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

std::vector<float> timesByAzimuth(const PointCloud& cloud, const PointTimeParams& params) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  std::vector<float> times;
  times.reserve(cloud.size());
  for (const Eigen::Vector3f& p : cloud.points) {
    double turned_rad = std::atan2(p.y(), p.x()) - params.sweep_start_rad;
    if (params.clockwise) turned_rad = -turned_rad;
    turned_rad -= kTurn * std::floor(turned_rad / kTurn);
    times.push_back(static_cast<float>(turned_rad / kTurn * params.sweep_period_s));
  }
  return times;
}

}  // namespace

void fields(FieldVisitor& v, PointTimeParams& p) {
  v.choice("source", p.source, {"none", "observation", "azimuth"},
           "Times of the points within a sweep: all at the stamp, as the observation says, or from "
           "the azimuth "
           "of a sensor that turns at a constant rate");
  v.number("sweep_period_s", p.sweep_period_s, "Duration of one turn (azimuth only)",
           Range::positive());
  v.angle("sweep_start_deg", p.sweep_start_rad,
          "Azimuth at the stamp, in the sensor frame (azimuth only)", Range::between(-360, 360));
  v.flag("clockwise", p.clockwise, "Turns clockwise seen from above (azimuth only)");
}

std::vector<float> pointTimes(const PointCloud& cloud, const PointTimeParams& params) {
  switch (params.source) {
    case PointTimeSource::kNone:
      return {};
    case PointTimeSource::kObservation:
      return cloud.time_offset_s;
    case PointTimeSource::kAzimuth:
      return timesByAzimuth(cloud, params);
  }
  return {};
}

double middleOfSweep(const std::vector<float>& times_s) {
  if (times_s.empty()) return 0.0;
  const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
  return 0.5 * (static_cast<double>(*first) + static_cast<double>(*last));
}

}  // namespace dynemo
