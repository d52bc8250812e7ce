#pragma once

#include <vector>

#include "dynemo/ingest/observation_stream.h"

namespace dynemo {

/// Reads on until one sensor has covered `duration_s`, and on while there is nothing but odometry;
/// bounded in memory whatever the stamps are.
std::vector<TimedItem> readBeginning(ObservationStream& stream, double duration_s);

}  // namespace dynemo
