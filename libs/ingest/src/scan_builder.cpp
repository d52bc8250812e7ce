#include "scan_builder.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace dynemo {

ScanBuilder::ScanBuilder(const DecodeContext& context, std::size_t expected_points)
    : context_(context) {
  const LidarParams& lidar = context.params.lidar;
  min_range_sq_ = static_cast<float>(lidar.min_range_m * lidar.min_range_m);
  max_range_sq_ = static_cast<float>(lidar.max_range_m * lidar.max_range_m);
  cloud_.points.reserve(expected_points);
}

void ScanBuilder::organise(std::size_t rows, std::size_t columns) {
  constexpr std::size_t kMost = std::numeric_limits<std::uint16_t>::max();
  if (rows > kMost || columns > kMost) return;
  cloud_.rows = static_cast<std::uint16_t>(rows);
  cloud_.columns = static_cast<std::uint16_t>(columns);
  cloud_.row.reserve(cloud_.points.capacity());
  cloud_.column.reserve(cloud_.points.capacity());
}

void ScanBuilder::add(const Eigen::Vector3f& point, std::optional<float> time_offset_s,
                      std::size_t row, std::size_t column) {
  const float range_sq = point.squaredNorm();
  if (!std::isfinite(range_sq)) {
    ++not_finite_;
  } else if (range_sq < min_range_sq_ || range_sq > max_range_sq_) {
    ++out_of_range_;
  } else {
    cloud_.points.push_back(point);
    if (time_offset_s) cloud_.time_offset_s.push_back(*time_offset_s);
    if (cloud_.rows == 0) return;
    cloud_.row.push_back(static_cast<std::uint16_t>(row));
    cloud_.column.push_back(static_cast<std::uint16_t>(column));
  }
}

void ScanBuilder::addTimesFromAzimuth() {
  const LidarParams& lidar = context_.params.lidar;
  if (!lidar.sweep_rate_hz || !cloud_.time_offset_s.empty()) return;
  constexpr double kTurn = 2.0 * std::numbers::pi;
  cloud_.time_offset_s.reserve(cloud_.size());
  for (const Eigen::Vector3f& p : cloud_.points) {
    const double azimuth = std::atan2(static_cast<double>(p.y()), static_cast<double>(p.x()));
    double turned = azimuth - lidar.sweep_start_rad;
    if (lidar.sweep_clockwise) turned = -turned;
    turned -= kTurn * std::floor(turned / kTurn);
    cloud_.time_offset_s.push_back(static_cast<float>(turned / kTurn / *lidar.sweep_rate_hz));
  }
}

Expected<Scan, DecodeFailure> ScanBuilder::finish(const mrpt::obs::CObservation& observation) {
  context_.warnings.count("cloud: points that are not finite removed", not_finite_);
  context_.warnings.count("cloud: points out of range removed", out_of_range_);
  if (cloud_.empty()) return make_unexpected("the cloud is empty");
  const auto T_base_lidar = sensorPose(observation, context_);
  if (!T_base_lidar) return make_unexpected(T_base_lidar.error());
  addTimesFromAzimuth();
  return Scan{{}, std::move(cloud_), *T_base_lidar};
}

}  // namespace dynemo
