#pragma once

#include <cstdint>
#include <optional>

#include "dynemo/ingest/decoders.h"

namespace dynemo {

/// Collects the points of one sweep, leaving out (and counting) those that are not finite or out of
/// range, and adds what the configuration says about their times.
class ScanBuilder {
 public:
  ScanBuilder(const DecodeContext& context, std::size_t expected_points);

  /// Makes the cloud an organised one; every point must then be added with its row and column.
  void organise(std::size_t rows, std::size_t columns);

  void add(const Eigen::Vector3f& point) { add(point, std::nullopt, 0, 0); }
  void addTimed(const Eigen::Vector3f& point, float time_offset_s) {
    add(point, time_offset_s, 0, 0);
  }
  void add(const Eigen::Vector3f& point, std::optional<float> time_offset_s, std::size_t row,
           std::size_t column);

  /// The scan with its pose; the stamp is left to the caller. Counts what was removed.
  Expected<Scan, DecodeFailure> finish(const mrpt::obs::CObservation& observation);

 private:
  void addTimesFromAzimuth();

  const DecodeContext& context_;
  PointCloud cloud_;
  std::uint64_t not_finite_ = 0, out_of_range_ = 0;
  float min_range_sq_, max_range_sq_;
};

}  // namespace dynemo
