// CObservationRotatingScan: a range image by ring and azimuth. It stores no elevations, so they
// come from the configuration.
#include <mrpt/obs/CObservationRotatingScan.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dynemo/ingest/decoders.h"
#include "scan_builder.h"

namespace dynemo {
namespace {

using mrpt::obs::CObservationRotatingScan;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Columns from the first to the last one's azimuth; over a full turn, the column after the last is
/// the first again.
double columnSteps(double span_rad, std::size_t columns) {
  const double full_turn = 2.0 * std::numbers::pi;
  const bool wraps = std::abs(span_rad) > full_turn * (1.0 - 0.5 / static_cast<double>(columns));
  return static_cast<double>(wraps || columns == 1 ? columns : columns - 1);
}

struct Direction {
  double cos = 1, sin = 0;
  explicit Direction(double angle_rad) : cos(std::cos(angle_rad)), sin(std::sin(angle_rad)) {}
};

std::vector<Direction> azimuths(const CObservationRotatingScan& o, std::size_t columns) {
  std::vector<Direction> directions;
  directions.reserve(columns);
  const double steps = columnSteps(o.azimuthSpan, columns);
  for (std::size_t c = 0; c < columns; ++c)
    directions.emplace_back(o.startAzimuth + o.azimuthSpan * static_cast<double>(c) / steps);
  return directions;
}

void addPoints(const CObservationRotatingScan& o, const DecodeContext& context, ScanBuilder& scan) {
  const auto rows = static_cast<std::size_t>(o.rangeImage.rows());
  const auto columns = static_cast<std::size_t>(o.rangeImage.cols());
  const auto directions = azimuths(o, columns);
  const bool timed = std::isfinite(o.sweepDuration) && o.sweepDuration > 0.0;
  const double column_s = timed ? o.sweepDuration / columnSteps(o.azimuthSpan, columns) : 0.0;
  scan.organise(rows, columns);
  for (std::size_t r = 0; r < rows; ++r) {
    const Direction elevation(context.params.lidar.elevations_deg[r] * kDegree);
    for (std::size_t c = 0; c < columns; ++c) {
      const std::uint16_t units = o.rangeImage(static_cast<int>(r), static_cast<int>(c));
      if (units == 0) continue;
      const double range_m = units * o.rangeResolution;
      const double horizontal_m = range_m * elevation.cos;
      const Eigen::Vector3d p(horizontal_m * directions[c].cos, horizontal_m * directions[c].sin,
                              range_m * elevation.sin);
      std::optional<float> time;
      if (timed) time = static_cast<float>(static_cast<double>(c) * column_s);
      scan.add(p.cast<float>(), time, r, c);
    }
  }
}

}  // namespace

Expected<Scan, DecodeFailure> decodeRotatingScan(mrpt::obs::CObservation& observation,
                                                 const DecodeContext& context) {
  const auto& o = dynamic_cast<const CObservationRotatingScan&>(observation);
  const auto rows = static_cast<std::size_t>(o.rangeImage.rows());
  const std::size_t given = context.params.lidar.elevations_deg.size();
  if (o.rangeImage.empty()) return make_unexpected("the range image is empty");
  if (given != rows)
    return make_unexpected(
        "CObservationRotatingScan stores no elevations: lidar.elevations_deg must list " +
        std::to_string(rows) + " of them, has " + std::to_string(given));
  ScanBuilder scan(context, static_cast<std::size_t>(o.rangeImage.size()));
  addPoints(o, context, scan);
  return scan.finish(o);
}

}  // namespace dynemo
