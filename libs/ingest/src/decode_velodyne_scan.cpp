// CObservationVelodyneScan: raw packets, converted with the calibration they carry; every point has
// its own time.
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cmath>

#include "dynemo/ingest/decoders.h"
#include "scan_builder.h"

namespace dynemo {
namespace {

using mrpt::obs::CObservationVelodyneScan;

/// A sweep takes a fraction of this; larger offsets mean that the packet times are wrong.
constexpr double kLongestSweep_s = 1.0;

struct TimedPoint {
  Eigen::Vector3f point;
  double offset_s;
};

// MRPT's base class has no virtual destructor; nothing is deleted through it here.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wnon-virtual-dtor"
struct Collector final : CObservationVelodyneScan::PointCloudStorageWrapper {
  explicit Collector(mrpt::Clock::time_point scan_stamp) : stamp(scan_stamp) {}
  void add_point(float x, float y, float z, uint8_t, const mrpt::system::TTimeStamp& time, float,
                 uint16_t) override {
    const double ticks = static_cast<double>(time.time_since_epoch().count()) -
                         static_cast<double>(stamp.time_since_epoch().count());
    const double offset_s = ticks * 1e-7;
    times_are_sane = times_are_sane && std::abs(offset_s) < kLongestSweep_s;
    points.push_back({{x, y, z}, offset_s});
  }
  mrpt::Clock::time_point stamp;
  std::vector<TimedPoint> points;
  bool times_are_sane = true;
};
#pragma GCC diagnostic pop

}  // namespace

Expected<Scan, DecodeFailure> decodeVelodyneScan(mrpt::obs::CObservation& observation,
                                                 const DecodeContext& context) {
  auto& o = dynamic_cast<CObservationVelodyneScan&>(observation);
  if (o.scan_packets.empty()) return make_unexpected("the observation has no packets");
  CObservationVelodyneScan::TGeneratePointCloudParameters params;
  params.minDistance = static_cast<float>(context.params.lidar.min_range_m);
  params.generatePerPointTimestamp = true;
  Collector collector(o.timestamp);
  try {
    o.generatePointCloud(collector, params);
  } catch (const std::exception&) {
    return make_unexpected("the packets cannot be decoded");
  }
  if (!collector.times_are_sane)
    context.warnings.count("cloud: times of points ignored, more than a second off the scan's");
  ScanBuilder scan(context, collector.points.size());
  for (const TimedPoint& p : collector.points) {
    if (collector.times_are_sane)
      scan.addTimed(p.point, static_cast<float>(p.offset_s));
    else
      scan.add(p.point);
  }
  return scan.finish(o);
}

}  // namespace dynemo
