// What travels from the reader to the frames: one observation with its stamp.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <string>
#include <variant>

#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

enum class SensorRole : std::uint8_t { kScan, kImage, kDetection, kOdometry };

/// Scans and images stay undecoded until a frame needs them; the rest is small and decoded on
/// reading.
struct TimedItem {
  Stamp stamp;
  SensorRole role = SensorRole::kOdometry;
  std::string label;
  /// Place of the observation's class in the order of preference of its role; smaller is preferred.
  int rank = 0;
  std::variant<mrpt::obs::CObservation::Ptr, OdometryState, ExternalDetection> payload;
};

}  // namespace dynemo
