#pragma once

#include <optional>

#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

/// Base pose at another stamp, in the base frame at the frame's stamp, from odometry. Empty when
/// the stamps differ and the odometry is missing at one of them.
std::optional<Pose3> motionFromFrame(const SensorFrame& frame, Stamp other,
                                     const std::optional<OdometryState>& odometry_other);

}  // namespace dynemo
