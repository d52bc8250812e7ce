// One recorded observation on its way from the sensor to the file.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <string>
#include <vector>

#include "dynemo/core/time.h"

namespace dynemo::simulation {

/// Start of every recording, in UNIX seconds; another one for each seed so that datasets can be
/// told apart.
inline Stamp startStamp(int seed) {
  constexpr std::int64_t kEpoch_s = 1'700'000'000, kPerSeed_s = 10'000;
  return {(kEpoch_s + kPerSeed_s * seed) * 1'000'000'000};
}

enum class Sensor : std::uint8_t { kOdom3d, kOdom2d, kLidar, kCamera };

/// A sensor reading that is due. Times are whole microseconds.
struct Event {
  Sensor sensor = Sensor::kOdom3d;
  std::uint64_t index = 0;  ///< of the sensor's readings
  std::int64_t t_us = 0;

  double t_s() const { return static_cast<double>(t_us) * 1e-6; }
};

struct Reading {
  Event event;
  mrpt::obs::CObservation::Ptr observation;
  std::string image_file;  ///< of cameras: file name and content
  std::vector<unsigned char> image_bytes;
  std::size_t points = 0;
};

}  // namespace dynemo::simulation
