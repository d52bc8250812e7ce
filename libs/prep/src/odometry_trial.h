// Whether LiDAR odometry can follow the scans of a log.
#pragma once

#include <memory>

#include "dynemo/pipeline/robot_tracker.h"
#include "dynemo/prep/inspection.h"

namespace dynemo {

/// Lets dynemo-slam's LiDAR odometry run over some stretches of successive scans, evenly spread.
class OdometryTrial {
 public:
  /// `scans`: in the whole log. Throws ConfigError when the configured source of odometry is not to
  /// be had.
  OdometryTrial(const InspectionParams& params, bool rawlog_odometry, std::uint64_t scans);

  /// Takes the next frame, whose odometry may be replaced by the estimate.
  void add(SensorFrame& frame);

  /// Empty when the motion comes from elsewhere, or no scan was to be tried.
  std::optional<OdometryTrialResult> result();

 private:
  void beginStretch();
  void endStretch();

  RobotOdometryParams params_;
  bool rawlog_odometry_, active_;
  std::uint64_t spacing_ = 1, stretch_ = 0, index_ = 0;
  std::unique_ptr<RobotTracker> tracker_;
  OdometryTrialResult result_;
};

}  // namespace dynemo
