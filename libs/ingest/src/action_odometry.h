#pragma once

#include <mrpt/obs/CActionCollection.h>

#include <optional>

#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/ingest/warning_counter.h"

namespace dynemo {

/// Adds up the motion increments of CActionRobotMovement2D and CActionRobotMovement3D.
class ActionOdometry {
 public:
  /// Applies the best increment of the collection: of wheels or inertial odometry when there is
  /// one, else any. False when it has none.
  bool apply(const mrpt::obs::CActionCollection& actions, WarningCounter& warnings);
  /// The pose since the beginning; the covariance is lost with the first increment that has none.
  const OdometryState& state() const { return state_; }

 private:
  OdometryState state_{Pose3(), Matrix6::Zero()};
};

}  // namespace dynemo
